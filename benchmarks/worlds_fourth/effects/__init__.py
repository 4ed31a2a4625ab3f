"""Effects: three laws or four of each mechanism, and two of each kind that no catalogue has."""

from worlds_fourth.effects.choice import MECHANISMS, UNKNOWN_KINDS, Hidden, asked_for, choose_effect

__all__ = ["MECHANISMS", "UNKNOWN_KINDS", "Hidden", "asked_for", "choose_effect"]

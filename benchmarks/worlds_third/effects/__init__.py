"""Effects: one file a stage, two forms or more of most mechanisms, and kinds that no catalogue has."""

from worlds_third.effects.choice import MECHANISMS, UNKNOWN_KINDS, Effect, asked_for, choose_effect

__all__ = ["MECHANISMS", "UNKNOWN_KINDS", "Effect", "asked_for", "choose_effect"]

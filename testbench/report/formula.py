"""A formula in LaTeX as a picture: drawn by matplotlib, so that no page fetches a typesetter."""

from __future__ import annotations

import io
import re

LONGEST = 400  # characters; a longer line is not drawn
SIZE_PT = 13.0
WORDS = re.compile(r"\\text\{([^{}]*)\}")
RELATION = re.compile(r"\\mathrel\{(.)\}=")


def lines_of(latex: str) -> list[str]:
    r"""The formula and its definitions, one each: ``\quad`` stands between them."""
    return [part.strip().rstrip(",") for part in latex.split(r"\quad") if part.strip()]


def formula_svg(line: str) -> str:
    """One line without dollar signs as SVG, its letters drawn as outlines; empty where matplotlib cannot read it."""
    from matplotlib import mathtext
    from matplotlib.font_manager import FontProperties

    if len(line) > LONGEST or "$" in line:
        return ""
    # As matplotlib spells it, which drops the spaces between words.
    line = line.replace(r"\tfrac", r"\frac")
    line = WORDS.sub(lambda words: rf"\mathrm{{{words[1]}}}".replace(" ", r"\ "), line)
    line = RELATION.sub(r"\\;{\1}\\!{=}\\;", line)
    drawn = io.BytesIO()
    font = FontProperties(size=SIZE_PT, math_fontfamily="dejavuserif")
    try:
        mathtext.math_to_image(f"${line}$", drawn, format="svg", prop=font)
    except (ValueError, RuntimeError):
        return ""
    _, start, rest = drawn.getvalue().decode("utf-8").partition("<svg")
    return start + rest

"""The one error that a user is meant to read."""

from __future__ import annotations

MOST_SHOWN = 100  # characters of a value that a message quotes
# What pydantic says of fields, said of the entries of a file.
PLAINER = {
    "missing": "this entry is needed, and is not there",
    "extra_forbidden": "there is no such entry; leave it out, or mend its name",
}


class UserError(ValueError):
    """Bad input. The message says who, what is allowed, what came and what to do.

    The command line prints it as one line and exits with 2; it never shows a traceback for it.
    """


def first_problem(error: BaseException) -> str:
    """Turn a pydantic ``ValidationError`` into one sentence: where, what is allowed, what came."""
    details = getattr(error, "errors", None)
    if details is None:
        return str(error)
    problem = details(include_url=False)[0]
    where = ".".join(str(part) for part in problem["loc"])
    message = PLAINER.get(problem["type"], problem["msg"].removeprefix("Value error, "))
    came = problem.get("input")
    if isinstance(came, str) and len(came) > MOST_SHOWN:
        came = came[:MOST_SHOWN] + "..."
    shown = f", got {came!r}" if isinstance(came, int | float | str | bool | type(None)) else ""
    return f"{where}: {message}{shown}" if where else f"{message}{shown}"

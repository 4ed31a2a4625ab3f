"""`hide`: a case for the diagnosis, whose truth is sealed."""

from __future__ import annotations

import secrets
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.errors import UserError
from gcode.support.html import card
from gcode.support.kinds import number, whole
from gcode.support.strict import read_json
from testbench.recordings.channels import FORCE, RESISTANCE
from testbench.recordings.files import read_recording
from testbench.recordings.recording import Recording
from testbench.worlds import make_case
from testbench.worlds.case_folder import RECORDINGS, SEALED, check_new, write_case
from testbench.worlds.motions import GAUGE_LENGTH_MM

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

LARGEST_SEED = 2**31


@dataclass(frozen=True)
class HiddenCase:
    """Two recordings of one sensor with something hidden in it, on the disk.

    Attributes
    ----------
    folder : Path
    minutes : float
        Length of each recording.
    """

    folder: Path
    minutes: float

    @property
    def calibration(self) -> Recording:
        """The first recording."""
        return read_recording(self.folder / RECORDINGS / "calibration.csv", GAUGE_LENGTH_MM)

    @property
    def held_out(self) -> Recording:
        """The second recording, of another motion."""
        return read_recording(self.folder / RECORDINGS / "held_out.csv", GAUGE_LENGTH_MM)

    @property
    def truth(self) -> dict[str, Any]:
        """What is hidden, how strongly, and over which noise floor; look after your diagnosis."""
        return read_json(self.folder / SEALED / "truth.json", "truth")

    def __repr__(self) -> str:
        return f"<HiddenCase {self.folder}: two recordings of {self.minutes:g} min>"

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: folder and minutes; what is hidden stays sealed."""
        return {"folder": str(self.folder), "minutes": self.minutes}

    def to_frame(self) -> pd.DataFrame:
        """The samples of both recordings as one table; ``recording`` says which: ``calibration`` or ``held_out``."""
        import pandas as pd

        both = {"calibration": self.calibration.to_frame(), "held_out": self.held_out.to_frame()}
        return pd.concat(both, names=["recording"]).reset_index(level="recording").reset_index(drop=True)

    def plot(self, axes: Axes | Sequence[Axes] | None = None) -> Any:
        """Draw every channel of `calibration` over time, see `Recording.plot`."""
        return self.calibration.plot(axes)

    def _repr_html_(self) -> str:
        return card(repr(self)[1:-1], [], self.calibration._repr_html_(), self.held_out._repr_html_())

    def __str__(self) -> str:
        recordings = f"two recordings of {self.minutes:g} min; see {self.folder}/README.txt"
        truth = "what is hidden; open it after your diagnosis"
        return f"{self.folder}/{RECORDINGS}: {recordings}\n{self.folder}/{SEALED}/truth.json: {truth}"


def hide(
    effect: str | None,
    folder: str | Path,
    *,
    strength: float = 5.0,
    seed: int | None = None,
    world: str = "matched",
    minutes: float = 23.0,
    rate_hz: float = 40.0,
    noise: str = "any",
    protocol: str = "perlin",
    channels: str | Sequence[str] = (FORCE, RESISTANCE),
) -> HiddenCase:
    """Record a sensor twice with an effect hidden in it, and write the recordings and, apart, the truth.

    Parameters
    ----------
    effect : str or None
        An effect of the catalogue, ``none``, ``unknown``, or several with commas; None: drawn by seed.
    folder : path
        New or empty.
    strength : float
        RMS of what the sensor's own base laws cannot absorb, over the noise floor.
    seed : int, optional
        Of sensor, motion and noise: the same seed, the same files. Default: random.
    world : str
        Whose laws the sensor follows: ``matched`` to the catalogue's, ``mismatched``, or one of
        `testbench.worlds.base.WORLDS`.
    minutes, rate_hz : float
        Length in minutes and mean sampling rate in Hz of each recording.
    noise : str
        ``white``, ``ar1``, ``pink``, or ``any`` of them by seed.
    protocol : str
        Motion: ``perlin``, ``holds``, ``triangles``, ``return_to_zero`` or ``mix``.
    channels : str or sequence of str
        Which of ``force_N``, ``resistance_ohm`` are recorded.

    Returns
    -------
    HiddenCase

    Raises
    ------
    UserError
        For an unknown name, an impossible number, or a folder that is not empty.

    Examples
    --------
    >>> import tempfile
    >>> import testbench as tb
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     case = tb.hide("stress_relaxation", folder, seed=3, minutes=2)
    ...     [len(one.channels) for one in (case.calibration, case.held_out)], case.truth["verdict"]
    ([3, 3], 'missing')
    """
    if not isinstance(effect, str | None):
        raise UserError(f"effect: must be a name such as 'stress_relaxation', got {effect!r}")
    check_new(folder)
    case = make_case(
        effect,
        number("strength", strength),
        world,
        secrets.randbelow(LARGEST_SEED) if seed is None else whole("seed:", seed, 0),
        number("minutes", minutes),
        number("rate_hz", rate_hz),
        noise,
        protocol=protocol,
        channels=tuple(channels) if isinstance(channels, Iterable) and not isinstance(channels, str) else (channels,),
    )
    return HiddenCase(write_case(folder, case), float(minutes))

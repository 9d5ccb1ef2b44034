"""One record written as each network writes it, after the published descriptions (docs/records.md)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

G = 9.80665
# of five samples, for what is read wrong
AT2 = """PEER STRONG MOTION DATABASE RECORD
A TEST, 000
ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: NONE
NPTS=  5, DT= .02000 SEC
  .1E-01  -.2000000E+00   .3
  0.4 -0.05
"""
DT = 0.01
_TIME = DT * np.arange(200)
_WAVE = 2.0 * np.exp(-(((_TIME - 0.8) / 0.3) ** 2)) * np.sin(2.0 * np.pi * 3.0 * _TIME)
SAMPLES = _WAVE - np.mean(_WAVE)  # m/s2; K-NET's have no mean


def _rows(values: Sequence[str], each: int) -> str:
    return "\n".join("".join(values[k : k + each]) for k in range(0, len(values), each)) + "\n"


def fortran_e(value: float, width: int, digits: int) -> str:
    """Return a number in Fortran's Ew.d, whose mantissa lies between 0.1 and 1, without the 0 before its point."""
    if value == 0.0:
        return f"{'.' + '0' * digits + 'E+00':>{width}}"
    exponent = int(np.floor(np.log10(abs(value)))) + 1
    mantissa = round(abs(value) / 10.0**exponent * 10**digits)
    if mantissa == 10**digits:
        mantissa, exponent = mantissa // 10, exponent + 1
    text = f"{'-' if value < 0.0 else ''}.{mantissa:0{digits}d}E{exponent:+03d}"
    return f"{text:>{width}}"


def at2(size: str = "NPTS=  {n}, DT= {dt:.5f} SEC", units: str = "ACCELERATION TIME HISTORY IN UNITS OF G") -> str:
    """Return PEER's format: five E15.7 in g a row."""
    head = f"PEER STRONG MOTION DATABASE RECORD\nTESTVILLE 01/01/00, D\u00fczce, 090\n{units}\n{size}\n"
    return head.format(n=len(SAMPLES), dt=DT) + _rows([fortran_e(a / G, 15, 7) for a in SAMPLES], 5)


def at2_touching() -> str:
    """Return the record in columns as narrow as their numbers, so that every minus sign touches the number before."""
    head = at2().split("\n")[:4]
    values = [fortran_e(a / G, 13, 7) for a in SAMPLES]
    return "\n".join(head) + "\n" + _rows(values, 6)


def esm() -> str:
    """Return ESM's format: header of DYNA 1.2, one value in cm/s2 a line."""
    given = {"EVENT_NAME": "TESTVILLE", "EVENT_ID": "XX-2000-0001", "EVENT_TIME_HHMMSS": "134126", "MAGNITUDE_L": ""}
    given |= {"NETWORK": "XX", "STATION_CODE": "TST", "VS30_M/S": "", "STREAM": "HNE"}
    given |= {"DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS": "20000101_134250.000", "SAMPLING_INTERVAL_S": f"{DT:.6f}"}
    given |= {"NDATA": f"{len(SAMPLES)}", "DURATION_S": "2.000", "UNITS": "cm/s^2", "INSTRUMENT_ANALOG/DIGITAL": "D"}
    given |= {"PGA_CM/S^2": "187.1", "HEADER_FORMAT": "DYNA 1.2", "DATA_TYPE": "ACCELERATION", "USER5": ""}
    return "".join(f"{key}: {value}\n" for key, value in given.items()) + "".join(f"{100.0 * a:.6f}\n" for a in SAMPLES)


COUNT = 3920.0 / 6182761 / 100.0  # m/s2 a count of K-NET's recorder


def knet(direction: str = "N-S", most: str = "Max Acc. (gal)") -> str:
    """Return K-NET's format: 17 lines of header, eight counts a row about a zero of the recorder."""
    peak = 100.0 * np.max(np.abs(SAMPLES))
    head = f"""Origin Time       2006/01/18 23:25:00
Lat.              37.798
Lon.              142.200
Depth. (km)       36
Mag.              5.7
Station Code      TST002
Station Lat.      38.7262
Station Lon.      141.5109
Station Height(m) 79
Record Time       2006/01/18 23:25:46
Sampling Freq(Hz) 100Hz
Duration Time(s)  2
Dir.              {direction}
Scale Factor      3920(gal)/6182761
{most:<17} {peak:.3f}
Last Correction   2006/01/18 23:25:31
Memo.
"""
    return head + _rows([f"{round(a / COUNT) + 8003:9d}" for a in SAMPLES], 8)


def _cosmos_channel(number: int, samples: np.ndarray, units: str, layout: str, value: Callable[[float], str]) -> str:
    each = int(layout.split("F")[0].split("E")[0])
    text = [f"Corrected acceleration    (Format v01.20 with 13 text lines) Channel {number}"]
    text += [f"text line {k}" for k in range(2, 9)]
    text += [f"Sta Chan   {number}: {90 * number} deg (Rcrdr Chan  {number}) Location:Free field"]
    text += [f"text line {k}" for k in range(10, 13)]
    text += ["Values used when parameter or data value is unknown/unspecified:   -999 -999.0"]
    integers, reals = [f"{-999:8d}"] * 100, [f"{-999.0:13.6f}"] * 100
    reals[33] = f"{DT:13.6f}"
    text += [" 100 Integer-header values follow on  10 lines, Format= (10I8)", _rows(integers, 10).rstrip()]
    text += [" 100 Real-header values follow on  17 lines, Format= (6F13.6)", _rows(reals, 6).rstrip()]
    text += ['   1 Comment line(s) follow, each starting with a "|":', "| a comment"]
    for what, unit, factor in (("acceleration", units, 1.0), ("velocity", "cm/s", 0.1), ("displacement", "cm", 0.01)):
        text += [f"{len(samples):8d} {what} pts, approx   2 secs, units={unit},Format=({layout})"]
        text += [_rows([value(factor * a) for a in samples], each).rstrip("\n")]
        text += [f"End-of-data for Chan  {number} {what}"]
    return "\n".join(text) + "\n"


def cosmos_v2(channels: int = 1) -> str:
    """Return COSMOS V2: F10.5 in cm/s2; with velocities and displacements, which are none of ours; more channels
    mirrored.
    """
    return "".join(
        _cosmos_channel(k, 100.0 * (-1.0) ** (k - 1) * SAMPLES, "cm/s^2 (4)", "8F10.5", lambda a: f"{a:10.5f}")
        for k in range(1, channels + 1)
    )


def cosmos_v1() -> str:
    """Return COSMOS V1 in g, one E15.6 a line."""
    return _cosmos_channel(1, SAMPLES / G, "g (02)", "1E15.6", lambda a: f"{a:15.6E}")


def csmip_v2() -> str:
    """Return CSMIP V2: the line above the numbers gives number, step, units and columns, which touch."""
    line = f"{len(SAMPLES):5d} points of accel data equally spaced at  .010 sec, in cm/sec2. (8f8.3)"
    values = _rows([f"{100.0 * a:8.3f}" for a in SAMPLES], 8)
    veloc = f"{len(SAMPLES):5d} points of veloc data equally spaced at  .010 sec, in cm/sec.  (8f8.3)"
    end = "/&  ---------- End of data for channel  1 ----------"
    return f"Corrected accelerogram\nChan  1: 90 Deg\n{line}\n{values}{veloc}\n{values}{end}\n"


def cosmos_v1c() -> str:
    """Return COSMOS V1 as CESMD writes it: a point after the unit, no comma before the format, columns that touch."""
    text = cosmos_v1().split("\n")
    k = next(k for k, line in enumerate(text) if "acceleration pts" in line)
    text[k] = f"{len(SAMPLES):8d} acceleration pts, approx   2 secs, units=g.     (02)Format=(8f9.6)"
    values = _rows([f"{a / G:9.6f}" for a in SAMPLES], 8).rstrip("\n").split("\n")
    return "\n".join([*text[: k + 1], *values, *text[k + 1 + len(SAMPLES) :]])


def csmip_v1(units: str = "g .     ") -> str:
    """Return CSMIP V1 of 1999 to 2019: 27 lines, two lists of numbers, then number, rate, units and columns; two
    channels.
    """
    head = [f"text line {k}" for k in range(1, 28)]
    head[10] = f"No. of Points =    {len(SAMPLES)}  Record Length =  2.000 sec   at 100 Samples/sec"
    line = f"{len(SAMPLES):6d} Accelerogram points at 100 pts/sec in units of {units} Format: (8f9.6)"
    channels = []
    for number, sign in ((1, 1.0), (2, -1.0)):
        values = _rows([f"{sign * a / G:9.6f}" for a in SAMPLES], 8).rstrip("\n")
        end = f"/&  ---------- End of data for channel  {number} ----------"
        channels += [*head[:5], f"Chan  {number}: {90 * number} Deg", *head[6:], line, values, end]
    return "\n".join(channels) + "\n"


def smc() -> str:
    """Return SMC: 11 lines of text, 48 integers, 50 reals, comments, eight numbers in cm/s2, columns that touch."""
    head = ["2 CORRECTED ACCELEROGRAM", "*", "TST", "     2000   1   1 Testville", "*", "station = Test", *["*"] * 5]
    integers, reals = [f"{-32768:10d}"] * 48, [f"{'0.1700000E+39':>15}"] * 50
    integers[15], integers[16], reals[1] = f"{2:10d}", f"{len(SAMPLES):10d}", f"{'0.1000000E+03':>15}"
    values = [f"{100.0 * a:10.3f}" for a in SAMPLES]
    return "\n".join(head) + "\n" + _rows(integers, 8) + _rows(reals, 5) + "|\n|a comment\n" + _rows(values, 8)


def geonet() -> str:
    """Return GeoNet V2A: channels of 26 lines, then accelerations, velocities and displacements in columns of 8."""
    channels = []
    for name, sign in (("N10E", 1.0), ("Up", -1.0)):
        head = ["Corrected accelerogram 20000101_000000_TST GNS Science", "Site TST  a place", *["text"] * 10]
        integers, steps = [f"{0:8d}"] * 10, [f"{0.0:8.4f}"] * 10
        integers[3:6], steps[5] = [f"{len(SAMPLES):8d}"] * 3, f"{DT:8.4f}"
        head += [f"Component {name}", "text", "text", "text", *["".join([f"{0:8d}"] * 10)] * 3, "".join(integers)]
        head += ["".join([f"{0.0:8.4f}"] * 10)] * 2 + ["".join(steps)] + ["".join([f"{0.0:8.4f}"] * 10)] * 3
        values = _rows([f"{sign * 1e3 * a:8.2f}" for a in SAMPLES], 10)
        channels.append("\n".join(head) + "\n" + values * 3)
    return "".join(channels)


def csv(separator: str = ",", header: Sequence[str] = ("time", "base.ax")) -> str:
    """Return the CSV of this project."""
    rows = [f"{t:.17g}{separator}{a:.17g}" for t, a in zip(_TIME, SAMPLES, strict=True)]
    return "\n".join([separator.join(header), *rows]) + "\n"


def plain(units: float = G, each: int = 1, digits: int = 9) -> str:
    """Return numbers alone, in units of `units` m/s2."""
    return "# a remark\n" + _rows([f" {a / units:.{digits}f}" for a in SAMPLES], each)


def plain_pairs(units: float = 0.01, separator: str = " ") -> str:
    """Time and acceleration."""
    return "".join(f"{t:.4f}{separator}{a / units:.9f}\n" for t, a in zip(_TIME, SAMPLES, strict=True))


@dataclass(frozen=True)
class Case:
    """A file, what it must be taken for, what must be said beside it, and how far off its digits leave the samples."""

    text: str
    format: str
    off: float  # m/s2, half a unit of the last digit
    given: dict[str, Any]


def _case(text: str, name: str, off: float, **given: object) -> Case:
    return Case(text, name, 1.001 * off + 1e-15, given)


_PEER = 0.5e-7 * G  # digits of .1234567E+00, of a PGA in g below 1
CASES = {
    "at2": _case(at2(), "PEER AT2", _PEER),
    "at2 other header": _case(at2("{n}    {dt:.4f}    NPTS, DT"), "PEER AT2", _PEER),
    "at2 nga-west2": _case(
        at2("NPTS=   {n}, DT=   .0100 SEC,", "ACCELERATION TIME SERIES IN UNITS OF G"), "PEER AT2", _PEER
    ),
    "at2 touching": _case(at2_touching(), "PEER AT2", _PEER),
    "esm": _case(esm(), "ESM ASCII", 0.5e-6 * 0.01),
    "knet": _case(knet(), "K-NET ASCII", COUNT),
    "kiknet": _case(knet("4", "Max. Acc. (gal)"), "K-NET ASCII", COUNT),
    "cosmos v1": _case(cosmos_v1(), "COSMOS or CSMIP V1/V2", 0.5e-7 * G),
    "cosmos v2": _case(cosmos_v2(), "COSMOS or CSMIP V1/V2", 0.5e-5 * 0.01),
    "cosmos v2 second": _case(cosmos_v2(3), "COSMOS or CSMIP V1/V2", 0.5e-5 * 0.01, channel=3),
    "cosmos v1 of cesmd": _case(cosmos_v1c(), "COSMOS or CSMIP V1/V2", 0.5e-6 * G),
    "smc": _case(smc(), "USGS SMC", 0.5e-3 * 0.01),
    "geonet": _case(geonet(), "GeoNet V1A/V2A", 0.5e-2 * 1e-3, channel=1),
    "csmip v1": _case(csmip_v1(), "COSMOS or CSMIP V1/V2", 0.5e-6 * G, channel=1),
    "csmip v2": _case(csmip_v2(), "COSMOS or CSMIP V1/V2", 0.5e-3 * 0.01),
    "csv": _case(csv(), "CSV", 0.0),
    "csv of a spreadsheet": _case(csv(";", ("Time", "BASE.AX")) + "\n\n", "CSV", 0.0),
    "csv with tabs": _case(csv("\t", ("TIME", " base.ax")), "CSV", 0.0),
    "plain in g": _case(plain(), "plain columns", 0.5e-9 * G, dt=DT, units="g"),
    "plain in m/s2": _case(plain(1.0, 7), "plain columns", 0.5e-9, dt=DT, units="m/s2"),
    "plain in cm/s2": _case(plain_pairs(), "plain columns", 0.5e-11, units="cm/s^2"),
    "plain with commas": _case(plain_pairs(1.0, " , "), "plain columns", 0.5e-9, units="m/s2"),
}
ENCODINGS: dict[str, Callable[[str], bytes]] = {
    "utf-8": lambda text: text.encode(),
    "latin-1": lambda text: text.encode("latin-1"),
    "utf-8 with mark": lambda text: text.encode("utf-8-sig"),
    "utf-16": lambda text: text.encode("utf-16"),
    "crlf": lambda text: text.replace("\n", "\r\n").encode("latin-1"),
    "cr": lambda text: text.replace("\n", "\r").encode(),
    "no end of line": lambda text: text.rstrip("\n").encode(),
}

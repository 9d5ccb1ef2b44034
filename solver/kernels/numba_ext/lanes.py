"""A number for each of eight columns: functions on lanes (lane_types.py), or stand-ins where nothing compiles."""

from .jit import COMPILES, for_kernels

WIDTH = 8

if COMPILES:
    from .lane_types import (
        LANES,
        MASK,
        LanesType,
        MaskType,
        any_of,
        bits,
        greater,
        index_of,
        lane,
        lesser,
        magnitude,
        mirrored,
        most_of,
        nearest,
        opposite,
        rarely,
        splat,
        square_root,
        where,
        with_lane,
        with_sign,
        zero_like,
    )
else:
    LANES = MASK = LanesType = MaskType = for_kernels  # type: ignore
    any_of = bits = greater = index_of = lane = lesser = magnitude = mirrored = most_of = nearest = for_kernels
    opposite = rarely = splat = square_root = where = with_lane = with_sign = zero_like = for_kernels

__all__ = [
    "LANES",
    "MASK",
    "WIDTH",
    "LanesType",
    "MaskType",
    "any_of",
    "bits",
    "greater",
    "index_of",
    "lane",
    "lesser",
    "magnitude",
    "mirrored",
    "most_of",
    "nearest",
    "opposite",
    "rarely",
    "splat",
    "square_root",
    "where",
    "with_lane",
    "with_sign",
    "zero_like",
]

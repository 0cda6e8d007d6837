# The combinations of the settings of a grid, in the syntax of `occluscope sweep --grid`.

import itertools
import math
import re
import struct
from decimal import Decimal

from snakemake.exceptions import WorkflowError


def combinations(grid, documentation):
    """The flags of each combination by a name such as `k=3_t=0.6`. `documentation()` is what `occluscope settings` prints.

    Names have no commas, at which Snakemake cuts the wildcards of jobs of a cluster.
    """
    axes = [axis(text, documentation) for text in grid]
    found = {}
    for values in itertools.product(*axes):
        name = "_".join(f"{setting}={value}" for setting, value in values)
        name = re.sub(r"[^A-Za-z0-9.=_-]", "_", name) or "base"
        if name in found:
            raise WorkflowError(f"the grid has {name} twice; use fewer values")
        found[name] = [part for setting, value in values for part in ("--" + setting, value)]
    return found


def axis(text, documentation):
    """The setting and a value, for each value of a text such as `k=3,4,5`, `t=0.5..0.9:5` or `alpha=log:0.0005..0.05:9`."""
    setting, equals, values = (part.strip() for part in str(text).partition("="))
    if not equals:
        raise WorkflowError(f"grid: `{text}`: give a setting and its values, as in k=3,4,5")
    setting = setting.replace("_", "-")
    if ".." in values:
        values = values_of_range(text, setting, values, documentation())
    else:
        values = [value.strip() for value in values.split(",")]
    return [(setting, value) for value in values]


def values_of_range(text, setting, values, documentation):
    form = re.fullmatch(r"(log:)?\s*([^:]+?)\s*\.\.\s*([^:]+?)\s*:\s*(\d+)", values)
    default = re.search(rf"^{re.escape(setting.replace('-', '_'))} = ([0-9.]+)$", documentation, re.MULTILINE)
    if default is None:
        raise WorkflowError(f"grid: `{text}`: there is no setting {setting} that has ranges; see `occluscope settings`")
    try:
        is_logarithmic, first, last, count = bool(form[1]), float(form[2]), float(form[3]), int(form[4])
    except (TypeError, ValueError):
        raise WorkflowError(f"grid: `{text}`: a range is FIRST..LAST:COUNT or log:FIRST..LAST:COUNT, as in 0.5..0.9:5")
    if count < 2:
        raise WorkflowError(f"grid: `{text}`: a range has at least 2 values")
    if is_logarithmic and min(first, last) <= 0:
        raise WorkflowError(f"grid: `{text}`: the ends of a logarithmic range are greater than 0")
    shares = [at / (count - 1) for at in range(1, count - 1)]
    if is_logarithmic:
        between = [first * (last / first) ** share for share in shares]
    else:
        between = [first + (last - first) * share for share in shares]
    # The default of a whole number has no point.
    is_real = "." in default[1]
    to_text = real_text if is_real else lambda value: str(math.floor(value + 0.5))
    # Values between the ends have four digits, unless the range is so narrow that they need more.
    if is_real and abs(last - first) >= 0.01 * count * max(abs(first), abs(last)):
        between = [float(f"{value:.3e}") for value in between]
    return [to_text(value) for value in (first, *between, last)]


def real_text(value):
    """The shortest decimal number that is the same number of 32 bits, as the program has it."""
    single = lambda number: struct.unpack("f", struct.pack("f", number))[0]
    texts = (f"{single(value):.{digits}g}" for digits in range(1, 10))
    return format(Decimal(next(text for text in texts if single(float(text)) == single(value))), "f")

"""Units are checked, not believed: what in a recording contradicts itself.

Four kinds of evidence. `values`: the stored numbers (bits rotated before storing; the smallest
difference; steps of disparity, which grow with z² by a factor that few sensors have). `unit`:
what sensors see and how they count, each candidate factor weighed as a whole. `motion`: with
poses, whether frames agree on where surfaces are, under the given and every other way to read
unit and poses. `outlines`: whether outlines in depth lie on edges in colour. Each doubts only
where another reading explains far better; too little evidence gives no doubt.
"""

from curiosight.datasets.doubts.doubt import Doubt
from curiosight.datasets.doubts.find import find_doubts

__all__ = ["Doubt", "find_doubts"]

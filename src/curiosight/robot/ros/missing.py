"""What is missing for maps and for learning, in words, by what is seen of the graph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

# Later than this a topic has gone silent, seconds.
SILENT_S = 2.0
# What comes so late, or so early, by its stamp, is of another clock, seconds.
ANOTHER_CLOCK_S = 60.0
# Of what is offered and asked for; the first offers least.
RELIABILITY = ("best_effort", "reliable")
DURABILITY = ("volatile", "transient_local")


@dataclass(frozen=True, slots=True)
class Quality:
    """How an end of a topic sends or wants to receive."""

    reliability: str
    durability: str

    def lacks(self, asked: Quality) -> list[str]:
        """Return, in words, what an offer lacks for what is asked for."""
        found = []
        for what, ranks in (("reliability", RELIABILITY), ("durability", DURABILITY)):
            offer, demand = getattr(self, what), getattr(asked, what)
            if offer in ranks and demand in ranks and ranks.index(offer) < ranks.index(demand):
                found.append(f"{what} {offer} is offered, {demand} asked for")
        return found


@dataclass(frozen=True, slots=True)
class TopicSeen:
    """What is seen of a topic that we listen to.

    what: what it is for us. kind: the message type we want; kinds: those that are published.
    offers: the quality of each publisher. n: messages so far; silent_s: since the last; None =
    none came. policies: those that the middleware said do not fit. ahead_s: the last stamp minus
    our clock.
    """

    name: str
    what: str
    kind: str
    asked: Quality
    kinds: Sequence[str] = ()
    offers: Sequence[Quality] = ()
    n: int = 0
    silent_s: float | None = None
    policies: Sequence[str] = ()
    ahead_s: float | None = None
    is_once: bool = False

    @property
    def misfit(self) -> str | None:
        """Say in what the quality of a publisher does not fit; None = all fit."""
        lacking = sorted({one for offer in self.offers for one in offer.lacks(self.asked)})
        if not lacking:
            lacking = [f"{policy.lower()} differs" for policy in self.policies]
        if not lacking:
            return None
        return f"QoS does not fit on {self.name} ({self.what}): {'; '.join(lacking)}"

    def missing(self, alike: Sequence[str] = ()) -> str | None:
        """Say what is wrong; None = nothing. alike: topics of this type that there are."""
        if not self.kinds:
            others = [name for name in alike if name != self.name][:5]
            hint = f"; of this type there is {', '.join(others)}" if others else ""
            return f"no publisher on {self.name} ({self.what}){hint}"
        if self.kind not in self.kinds:
            return f"{self.name} ({self.what}) is {self.kinds[0]}, not {self.kind}"
        if self.silent_s is None and self.misfit:
            return self.misfit
        if self.silent_s is None:
            return f"nothing comes on {self.name} ({self.what}), though it has a publisher"
        if self.silent_s > SILENT_S and not self.is_once:
            return f"{self.name} ({self.what}) has been silent for {self.silent_s:.0f} s"
        if self.ahead_s is not None and abs(self.ahead_s) > ANOTHER_CLOCK_S:
            what = "ahead of" if self.ahead_s > 0 else "behind"
            told = f"{abs(self.ahead_s):.0f} s {what} this node's clock"
            return f"{self.name} ({self.what}) is stamped {told}: use_sim_time?"
        return None


@dataclass(frozen=True, slots=True)
class Seen:
    """What is seen of all inputs at a moment. apart_s: of the last colour and its nearest depth.

    tf: what is missing to tell where the camera is, in words; None = nothing. refused: of those
    who listen to us: topic to what they ask for that we do not offer. lacks: why frames taught
    nothing lately, and how many.
    """

    topics: Sequence[TopicSeen]
    apart_s: float | None = None
    max_gap_s: float = 0.02
    tf: str | None = None
    refused: Mapping[str, str] = field(default_factory=dict)
    lacks: Mapping[str, int] = field(default_factory=dict)
    alike: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def missing(self) -> list[str]:
        """Return what is missing, the most important first; empty = nothing."""
        told = [one.missing(self.alike.get(one.kind, ())) for one in self.topics]
        found = [one for one in told if one is not None]
        if self.apart_s is not None and self.apart_s > self.max_gap_s:
            apart = f"{self.apart_s:.3f} s apart, {self.max_gap_s:g} s at most are allowed"
            found.append(f"stamps of colour and depth are {apart} (max_stamp_gap)")
        if self.tf is not None:
            found.append(self.tf)
        for topic, what in self.refused.items():
            found.append(f"QoS does not fit on {topic}, which somebody wants to read: {what}")
        for why, n in self.lacks.items():
            if not any(why in one for one in found):
                found.append(f"{n} frames taught nothing: {why}")
        return found

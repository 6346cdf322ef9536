"""Exploring with a fake Nav2 on a real graph."""

from __future__ import annotations

import time

from test_node import SLOW, has_begun

from conftest import Graph, Process

ERROR_STOPPED_FALLING, OUT_OF_TIME, NOWHERE, CANCELED, NO_NAVIGATION = range(5)
SUCCEEDED, STATUS_CANCELED, ABORTED = 4, 5, 6


def begun(graph: Graph, **parameters: object) -> tuple[Process, Process]:
    """Return a node that learns and has a map, and who calls it."""
    graph.camera(*SLOW)
    labels = graph.listener("/curiosight/labels", "sensor_msgs/msg/Image")
    node = graph.node("--learn", reliability="reliable", looks_per_goal=1, **parameters)
    has_begun(node)
    labels.json(150, lambda one: one["data"]["max"] == 255)
    return node, graph.caller()


def goals(nav2: Process, event: str = "goal") -> list[dict]:
    import json

    rows = [json.loads(line) for line in nav2.lines if line.startswith("{")]
    return [row for row in rows if row["event"] == event]


def test_explores_until_the_error_stops_falling_then_goes_home(graph: Graph) -> None:
    nav2 = graph.peer("fake_nav2")
    _, caller = begun(graph, patience=8, min_fall=0.9)
    assert caller.ask(do="explore", home=[3.0, 3.0])["accepted"]
    told = caller.ask(120, do="explored", seconds=120)
    assert told["reason"] == ERROR_STOPPED_FALLING
    assert (told["status"], told["is_home"]) == (SUCCEEDED, True)
    assert told["n_reached"] >= 1
    last = goals(nav2)[-1]
    assert (last["x"], last["y"], last["frame"]) == (3.0, 3.0, "map")
    assert any(one["name"] == "home" for one in told["feedback"])
    assert all(one["why"] for one in told["feedback"])


def test_refused_and_failed_goals_are_left_alone(graph: Graph) -> None:
    nav2 = graph.peer("fake_nav2", "--refuse-left-of", "3.0", "--fail-below", "3.0")
    _, caller = begun(graph, patience=100000, goal_spacing=1.5)
    assert caller.ask(do="explore", max_seconds=40.0, home=[5.0, 5.0])["accepted"]
    told = caller.ask(120, do="explored", seconds=120)
    assert told["reason"] == OUT_OF_TIME
    assert told["is_home"]
    bad = [(row["x"], row["y"]) for row in goals(nav2) if row["refused"]]
    bad += [(row["x"], row["y"]) for row in goals(nav2, "aborted")]
    assert len(bad) == len(set(bad)) == told["n_failed"] > 0
    assert told["n_reached"] > 0


def test_cancelled_exploring_cancels_the_drive(graph: Graph) -> None:
    nav2 = graph.peer("fake_nav2", "--seconds", "60")
    _, caller = begun(graph)
    assert caller.ask(do="explore")["accepted"]
    nav2.wait_for_text('"goal"', 20)
    caller.ask(do="spin", seconds=1.0)
    assert caller.ask(do="cancel")["n"] == 1
    told = caller.ask(20, do="explored", seconds=20)
    assert (told["status"], told["reason"]) == (STATUS_CANCELED, CANCELED)
    nav2.wait_for_text('"canceled"', 10)


def test_node_that_ends_stops_the_robot(graph: Graph) -> None:
    nav2 = graph.peer("fake_nav2", "--seconds", "60")
    node, caller = begun(graph)
    assert caller.ask(do="explore")["accepted"]
    nav2.wait_for_text('"goal"', 20)
    caller.ask(do="spin", seconds=1.0)
    assert node.end() == 143
    nav2.wait_for_text('"canceled"', 5)


def test_killed_navigation_ends_exploring_and_another_serves_the_next(graph: Graph) -> None:
    nav2 = graph.peer("fake_nav2", "--seconds", "60")
    node, caller = begun(graph)
    assert caller.ask(do="explore")["accepted"]
    nav2.wait_for_text('"goal"', 20)
    nav2.kill()
    node.wait_for_text("no navigation answers", 40)
    second = graph.peer("fake_nav2")
    second.wait_for_text('"reached"', 40)
    second.kill()
    told = caller.ask(90, do="explored", seconds=90)
    assert told["reason"] == NO_NAVIGATION
    assert told["status"] == ABORTED


def test_exploring_without_a_map_says_so(graph: Graph) -> None:
    graph.peer("fake_nav2")
    node, caller = begun(graph, map_topic="/no_map")
    assert caller.ask(do="explore")["accepted"]
    told = caller.ask(20, do="explored", seconds=20)
    assert told["status"] == ABORTED
    assert "no map has come on /no_map" in told["text"]
    time.sleep(0.5)
    assert node.process.poll() is None

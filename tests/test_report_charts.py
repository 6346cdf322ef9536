"""The report's learning curve, its map, and its strips of regions."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from curiosight.explorer.from_above import FromAbove
from curiosight.viewing.report import (
    Report,
    RoomMap,
    report_html,
)
from curiosight.viewing.report.region_time import region_styles
from reports import (
    NAMES,
    SQUARE,
    Row,
    of_class,
    points_of,
    read,
    report,
    room_map,
    rows,
    text_of,
)
from room import ROOM


class TestCurve:
    def test_points_are_the_errors(self):
        steps = rows()
        tree = read(replace(report(), steps=steps))
        (overall,), (dots,) = of_class(tree, "overall")[:1], of_class(tree, "dots")
        expected = [(100 * row.step / 39, 100 * (1 - row.overall_error)) for row in steps]
        np.testing.assert_allclose(points_of(overall.get("d")), expected, atol=0.006)
        known = [row for row in steps if row.error is not None]
        expected = [(100 * row.step / 39, 100 * (1 - row.error)) for row in known]
        np.testing.assert_allclose(points_of(dots.get("d")), expected, atol=0.006)

    def test_lines_are_named_with_the_error_at_their_end(self):
        ends = {text_of(label) for label in of_class(read(report()), "end")}
        late = [row.error for row in rows() if row.error is not None][-10:]
        assert ends == {f"{0.9**39:.2f}test views", f"{np.mean(late):.2f}each frame"}

    def test_mean_line_starts_with_the_first_error(self):
        steps = [Row(step, 0, 0.25, None) for step in range(5)]
        (mean, label) = of_class(read(replace(report(), steps=steps)), "mean")
        np.testing.assert_allclose(points_of(mean.get("d"))[:, 1], 75)
        assert text_of(label) == "0.25each frame"

    def test_one_step_is_a_point(self):
        tree = read(replace(report(), steps=[Row(0, 0, 0.5, 0.25)]))
        np.testing.assert_allclose(points_of(of_class(tree, "overall")[0].get("d")), [[0, 75]])


class TestMap:
    def test_dots_are_where_it_looked(self):
        tree, room = read(replace(report(), room_map=room_map())), room_map()
        dots = of_class(tree, "dot")
        places = {(float(dot.get("cx")), -float(dot.get("cy"))) for dot in dots}
        expected = {tuple(room.views.positions[view].round(3)) for view in (0, 3, 5)}
        assert places == expected
        largest = max(dots, key=lambda dot: float(dot.get("r")))
        assert float(largest.get("cx")) == pytest.approx(room.views.positions[3, 0], abs=1e-3)

    def test_wedges_open_to_where_it_looked(self):
        views = FromAbove(np.array([[1.0, 2.0], [0.0, 0.0]]), np.array([np.pi / 2, 0.0]))
        tree = read(replace(report(), room_map=RoomMap(views, np.array([0, 1]), [0])))
        (wedge,) = of_class(tree, "wedge")
        assert wedge.get("class") == "wedge r0"
        position, left, *_, right = points_of(re.sub(r"A\S+ \S+ 0 0 1 ", " ", wedge.get("d")))
        np.testing.assert_allclose(position, (1, -2))
        assert left[0] < 1 < right[0]
        assert left[1] == right[1] < -2, "up on the map is less in SVG"

    def test_walls_and_things_are_drawn_and_furniture_named(self):
        tree = read(replace(report(), room_map=room_map()))
        (walls,) = of_class(tree, "walls")
        np.testing.assert_allclose(points_of(walls.get("d")), [(-3, 3), (3, 3), (3, -3), (-3, -3)])
        assert len(of_class(tree, "furniture")) == len(ROOM)
        assert len(of_class(tree, "object")) == 1
        names = [text_of(name) for name in of_class(tree, "thing")]
        assert [name for name in names if name] == [f"box {i}" for i in range(len(ROOM))]

    def test_map_says_how_regions_are_named(self):
        tree = read(report())
        sections = {section.get("aria-labelledby"): section for section in tree.iter("section")}
        assert "Called kitchen." in text_of(sections["map"])

    @pytest.mark.parametrize(("outlines", "least", "most"), [((SQUARE,), 6, 6.4), ((), 2.2, 2.6)])
    def test_map_leaves_room_for_wedges_where_no_wall_holds_them(self, outlines, least, most):
        room = replace(room_map(), outlines=outlines, footprints=())
        (drawing,) = of_class(read(replace(report(), room_map=room)), "map")
        _, _, width, _ = map(float, drawing[0].get("viewbox").split())
        assert least < width < most

    def test_views_beyond_counting_stay_a_small_page(self):
        n_views = 30_000
        around = np.linspace(0, 2 * np.pi, n_views)
        views = FromAbove(np.stack([np.cos(around), np.sin(around)], axis=1), around)
        room = RoomMap(views, np.arange(n_views) % 3, list(range(0, n_views, 2)))
        assert len(report_html(Report("", "", room_map=room, region_names=NAMES))) < 600_000


class TestRegions:
    def test_rows_count_the_frames(self):
        tree = read(replace(report(), region_names=NAMES, steps=rows(30)))
        (table,) = of_class(tree, "regions")
        assert [text_of(row) for row in table.iter("tr")][1:] == [f"{name}10" for name in NAMES]

    def test_strips_fill_while_it_was_there(self):
        tree = read(replace(report(), region_names=NAMES, steps=rows(30)))
        for region, area in enumerate(of_class(tree, "share")):
            assert area.get("class") == f"share r{region}"
            points = points_of(area.get("d"))
            at_middle = points[np.argmin(np.abs(points[:, 0] - 100 * (region + 0.5) / 3))]
            assert at_middle[1] == 0, "the whole window was spent there"
            elsewhere = points[np.argmin(np.abs(points[:, 0] - 100 * ((region + 1.5) % 3) / 3))]
            assert elsewhere[1] == 100

    def test_progress_is_known_from_its_first_step_on_and_never_negative(self):
        known = [Row(0, 0, 1, 1), Row(1, 0, 1, 1, 0.4), Row(2, 1, 1, 1), Row(3, 0, 1, 1, -0.4)]
        tree = read(replace(report(), region_names=NAMES[:2], steps=known, decisions=()))
        (line,) = of_class(tree, "progress")
        expected = [(33.3, 0), (66.7, 0), (100, 100)]
        np.testing.assert_allclose(points_of(line.get("d")), expected)

    @given(st.lists(st.text("xy 012", min_size=1), min_size=1, max_size=20, unique=True))
    def test_colours_show_on_light_and_on_dark_pages(self, names):
        light, dark = region_styles(names).split("@media")
        for style, page in ((light, 1.0), (dark, 0.01)):
            codes = re.findall(r"\.r\d+\{--hue:#(\w{6})\}", style)
            assert len(codes) == len(names)
            for code in codes:
                srgb = np.array([int(code[i : i + 2], 16) / 255 for i in (0, 2, 4)])
                luminance = (srgb**2.2) @ [0.2126, 0.7152, 0.0722]
                contrast = (max(luminance, page) + 0.05) / (min(luminance, page) + 0.05)
                assert contrast > 1.7

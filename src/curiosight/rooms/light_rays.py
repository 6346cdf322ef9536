"""How much light arrives at a point: rays to the lamps, and rays all around."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from curiosight.rooms.mesh import Floats, Mesh
from curiosight.rooms.mipmaps import mean_albedo
from curiosight.rooms.scene import Light
from curiosight.rooms.tracing import RayCaster, portions

# Metres before a light at which its shadow rays end: the lamp's own glass gives no shadow.
CLEARANCE = 0.03
# What fills less of a point's view is not looked for.
SMALLEST_SHARE = 1e-3
# A light is looked for in 2 × 2 places; where these disagree, in 4 × 4.
FEW_STRATA, MANY_STRATA = 2, 4
# Metres within which a surface sends less light, as it gets less itself: corners and contacts
# are dark.
NEARNESS = 1.0
N_INDIRECT_RAYS = 24
# More even light than of this mean albedo would be of a room of mirrors.
LARGEST_ALBEDO = 0.8
# Points of one call: fixed, so that no result depends on the number of threads.
N_POINTS = 4096


@dataclass(frozen=True, slots=True, eq=False)
class Scattered:
    """Light that surfaces send back.

    once: (T, 3) of each triangle, straight from the lamps. albedo: (T, 3). even: (3,) light
    that met several surfaces, the same everywhere.
    """

    once: Floats
    albedo: Floats
    even: Floats


def scattered_light(mesh: Mesh, direct: Floats) -> Scattered:
    """Work out what the triangles send back of (V, 3) direct light at their corners."""
    albedo = mean_albedo(mesh.materials)[mesh.surface]
    once = albedo * direct[mesh.triangles].mean(1)
    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    mean_once = np.average(once, axis=0, weights=area)
    mean = np.minimum(np.average(albedo, axis=0, weights=area), LARGEST_ALBEDO)
    return Scattered(once, albedo, (mean_once / (1 - mean)).astype(np.float32))


class LightRays:
    """Gathers light at points; its generator turns the rays' pattern from point to point."""

    def __init__(
        self, caster: RayCaster, lights: Sequence[Light], rng: np.random.Generator
    ) -> None:
        self._caster = caster
        self._lights = lights
        self._rng = rng

    def direct(self, points: Floats, normals: Floats) -> Floats:
        """Return (P, 4): light of the lamps, and the share of it that is not in shadow."""
        shifts = self._rng.random((len(self._lights), len(points), 2), np.float32)

        def gather(portion: slice) -> Floats:
            here, upwards = points[portion], normals[portion]
            visible = np.zeros((len(here), 3), np.float32)
            unshadowed = np.zeros((len(here), 3), np.float32)
            for light, shift in zip(self._lights, shifts, strict=True):
                full = share_of_view(here, upwards, light)
                lit = np.flatnonzero(full > SMALLEST_SHARE)
                share = self._visible_share(here[lit], upwards[lit], light, shift[portion][lit])
                rgb = full[lit, None] * np.asarray(light.rgb, np.float32)
                unshadowed[lit] += rgb
                visible[lit] += share[:, None] * rgb
            share = visible.sum(1) / np.maximum(unshadowed.sum(1), np.float32(1e-6))
            return np.column_stack([visible, share])

        return np.concatenate(self._caster.map(gather, portions(len(points), N_POINTS)))

    def _visible_share(
        self, points: Floats, normals: Floats, light: Light, shift: Floats
    ) -> Floats:
        """Return the share of a light, (P,), that nothing hides; 0 where it is behind anyway."""
        share = self._share_of_strata(points, normals, light, shift, FEW_STRATA)
        edge = np.flatnonzero((share > 0) & (share < 1))
        share[edge] = self._share_of_strata(
            points[edge], normals[edge], light, shift[edge], MANY_STRATA
        )
        return share

    def _share_of_strata(
        self, points: Floats, normals: Floats, light: Light, shift: Floats, n_strata: int
    ) -> Floats:
        """Do so with rays to n_strata × n_strata places, each weighted with its light."""
        along, across = np.asarray(light.along, np.float32), np.asarray(light.across, np.float32)
        facing = np.cross(along, across)
        free: Floats = np.zeros(len(points), np.float32)
        full: Floats = np.full(len(points), 1e-12, np.float32)
        for cell in np.ndindex(n_strata, n_strata):
            place = (np.array(cell, np.float32) + shift) / n_strata - np.float32(0.5)
            towards = np.asarray(light.centre, np.float32) - points
            towards += place[:, :1] * along + place[:, 1:] * across
            squared = np.einsum("ij,ij->i", towards, towards)
            arriving = np.einsum("ij,ij->i", towards, normals)
            weight = arriving * -(towards @ facing) / squared**2
            lit = np.flatnonzero((arriving > 0) & (weight > 0))
            reach = np.maximum(1 - CLEARANCE / np.sqrt(squared[lit]), 0)
            is_free = self._caster.is_free(points[lit], towards[lit], reach)
            full[lit] += weight[lit]
            free[lit] += weight[lit] * is_free
        return free / full

    def indirect(self, points: Floats, normals: Floats, scattered: Scattered) -> Floats:
        """Return (P, 4): light of surfaces, and the share of rays that meet a back.

        Rays are sent as densely as their light counts.
        """
        first, second = tangents(normals, self._rng.random(len(points), np.float32))
        axes = np.stack([first, second, normals], 1)
        pattern = cosine_directions(N_INDIRECT_RAYS)

        def gather(portion: slice) -> Floats:
            directions = (pattern @ axes[portion]).reshape(-1, 3)
            hits = self._caster.hits(np.repeat(points[portion], len(pattern), 0), directions)
            openness = np.minimum(hits.distance / NEARNESS, 1)[:, None]
            light = scattered.albedo[hits.triangle] * (openness * scattered.even)
            light += scattered.once[hits.triangle] * np.sqrt(openness)
            is_behind = self._caster.is_behind(hits, directions)
            light[is_behind] = 0
            light[hits.triangle < 0] = scattered.even
            columns: Floats = np.column_stack([light, is_behind])
            means: Floats = columns.reshape(-1, len(pattern), 4).mean(1)
            return means

        return np.concatenate(self._caster.map(gather, portions(len(points), N_POINTS)))


def share_of_view(points: Floats, normals: Floats, light: Light) -> Floats:
    """Return the share of each point's view, (P,) weighted with the cosine, that a light fills.

    Lambert's formula for the light's four edges; where the light is partly below the horizon,
    as for a sphere that sends as much (Hill and Heitz, 2016).
    """
    half, side = np.asarray(light.along) / 2, np.asarray(light.across) / 2
    corners = light.centre + np.array([half + side, side - half, -half - side, half - side])
    towards = corners.astype(np.float32)[:, None] - points
    towards /= np.maximum(np.linalg.norm(towards, axis=2, keepdims=True), np.float32(1e-6))
    arriving = np.zeros_like(points)
    for one, other in zip(towards, np.roll(towards, -1, axis=0), strict=True):
        normal = np.cross(one, other)
        sine = np.linalg.norm(normal, axis=1)
        angle = np.arctan2(sine, np.einsum("ij,ij->i", one, other))
        arriving -= (angle / (2 * np.pi * np.maximum(sine, 1e-6)))[:, None] * normal
    total = np.linalg.norm(arriving, axis=1)
    share = (total**2 + np.einsum("ij,ij->i", arriving, normals)) / (total + 1)
    is_before = (points - light.centre) @ np.cross(light.along, light.across) > 0
    seen: Floats = (np.maximum(share, 0) * is_before).astype(np.float32)
    return seen


def tangents(normals: Floats, turn: Floats) -> tuple[Floats, Floats]:
    """Return two (P, 3) unit directions square to the normals, turned by shares of a circle."""
    x_axis, _, z_axis = np.eye(3, dtype=np.float32)
    helper = np.where(np.abs(normals[:, 2:]) > 0.7, x_axis, z_axis)
    first = np.cross(helper, normals)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), np.float32(1e-9))
    second = np.cross(normals, first)
    angle = np.float32(2 * np.pi) * turn[:, None]
    cos, sin = np.cos(angle), np.sin(angle)
    return cos * first + sin * second, cos * second - sin * first


def cosine_directions(n_rays: int) -> Floats:
    """Return (n_rays, 3) unit directions about z, as dense as their cosine with it."""
    index = np.arange(n_rays)
    radius = np.sqrt((index + 0.5) / n_rays)
    angle = index * np.pi * (3 - np.sqrt(5))  # a sunflower's spiral
    directions = [radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2)]
    return np.stack(directions, 1).astype(np.float32)

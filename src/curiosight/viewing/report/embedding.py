"""Images inside a page, small enough to be sent."""

from __future__ import annotations

import base64

import cv2

from curiosight.frame import Rgb

JPEG_QUALITY = 82


def shrunken(rgb: Rgb, max_width_px: int) -> Rgb:
    """Return the image at most as wide as it is shown."""
    height, width = rgb.shape[:2]
    if width <= max_width_px:
        return rgb
    size = (max_width_px, max(1, round(height * max_width_px / width)))
    small: Rgb = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)
    return small


def source(rgb: Rgb, ending: str = ".jpg") -> dict[str, str | float]:
    """Return the attributes that hold an image, and its size in pixels."""
    is_jpeg = ending == ".jpg"
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY] if is_jpeg else []
    _, encoded = cv2.imencode(ending, cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), options)
    kind = "jpeg" if is_jpeg else "png"
    content = base64.b64encode(encoded.tobytes()).decode("ascii")
    height, width = rgb.shape[:2]
    return {"src": f"data:image/{kind};base64,{content}", "width": width, "height": height}

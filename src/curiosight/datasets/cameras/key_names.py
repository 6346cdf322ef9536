"""What others call the numbers of their cameras, in small letters."""

from __future__ import annotations

from itertools import chain

MATRIX_KEYS = [
    "cam_k",
    "k",
    "intrinsic_matrix",
    "camera_matrix",
    "cameramatrix",
    "intrinsic",
    "intrinsics",
    "intrinsics_matrix",
    "matrix",
    "rgb_intrinsics",
    "color_intrinsics",
    "colour_intrinsics",
    "camera_intrinsics",
    "camera_intrinsic",
    "color_intrinsic",
    "depth_intrinsic",
    "kmat",
]
FOCAL_KEYS = {
    "fx": ["fx", "f_x", "focal_x", "fl_x", "focal_length_x", "fu", "alpha_x"],
    "fy": ["fy", "f_y", "focal_y", "fl_y", "focal_length_y", "fv", "alpha_y"],
    "cx": ["cx", "c_x", "ppx", "x_offset", "principal_x", "principal_point_x", "u0", "x0", "pp_x"],
    "cy": ["cy", "c_y", "ppy", "y_offset", "principal_y", "principal_point_y", "v0", "y0", "pp_y"],
}
SIZE_KEYS = (
    ["width", "w", "img_width", "image_width", "im_width", "cols", "colorwidth", "m_colorwidth"],
    [
        "height",
        "h",
        "img_height",
        "image_height",
        "im_height",
        "rows",
        "colorheight",
        "m_colorheight",
    ],
)
SCALE_KEYS = [
    "depth_scale",
    "depthscale",
    "depth_factor",
    "png_depth_scale",
    "factor_depth",
    "depthmapfactor",
    "depth_map_factor",
    "depth_unit",
    "depth_units",
    "depth_shift",
    "depthshift",
    "m_depthshift",
    "scale_factor",
    "depth_scale_factor",
]
# Of the place of the depth camera in the colour camera's axes.
POSE_KEYS = [
    "t_colour_depth",
    "t_color_depth",
    "depth_to_color",
    "depth_to_colour",
    "depth2color",
    "depth_to_rgb",
    "depth2rgb",
    "t_rgb_depth",
    "extrinsics",
    "extrinsic",
    "transform",
    "depth_to_color_extrinsics",
]
# What others write that is no key of ours, mistyped.
FOREIGN_KEYS = frozenset(
    chain(MATRIX_KEYS, *FOCAL_KEYS.values(), *SIZE_KEYS, SCALE_KEYS, POSE_KEYS)
)

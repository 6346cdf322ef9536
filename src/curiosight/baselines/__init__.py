"""Bottom-up saliency: what pops out of an image, with nothing learned."""

from curiosight.baselines.opencv import fine_grained, spectral_residual

__all__ = ["fine_grained", "spectral_residual"]

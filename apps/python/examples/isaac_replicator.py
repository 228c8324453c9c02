"""Broken glass as an augmentation of Isaac Sim's Replicator: an annotator `rgb_glass` beside `rgb`.

Inside of Isaac Sim, with a render product of its own:

    from isaac_replicator import register_glass
    register_glass("windshield-star", seed=7, size=(1280, 720))
    annotator = rep.annotators.get("rgb_glass")
    annotator.attach(render_product)

A writer or the ROS 2 bridge takes `rgb_glass` in the place of `rgb`. The pixels are augmented on the CPU:
with data on the GPU that is a round trip for each frame.

Needs Isaac Sim with omni.replicator.core, and starbreak in its Python.
"""

import numpy as np
import starbreak


class GlassAugmentation:
    """Puts broken glass over arrays of RGBA, as an annotator `rgb` gives them."""

    def __init__(self, recipe, seed, size, light="first"):
        self.crack = starbreak.ReadyCrack(recipe, seed, size)
        self.seed, self.light = seed, light
        self.n_frames = 0

    def __call__(self, data_in: np.ndarray) -> np.ndarray:
        """A new array behind the glass; the renderer's own is not changed."""
        pixels = np.asarray(data_in, dtype=np.uint8)
        if self.light == "first" and self.n_frames == 0:
            self.crack.set_environment(self.crack.estimate_environment(pixels, channels="rgba"))
        seed = starbreak.item_seed(self.seed, "rgb_glass", self.n_frames)
        self.n_frames += 1
        return self.crack.over(pixels, seed, out=np.empty_like(pixels), channels="rgba")


def register_glass(recipe="windshield-spiderweb", seed=0, size=(1280, 720), name="rgb_glass"):
    """Registers an annotator that gives `rgb` behind broken glass, and returns what augments it."""
    import omni.replicator.core as rep

    glass = GlassAugmentation(recipe, seed, size)

    # A plain function, as in Replicator's own examples.
    def behind_glass(data_in):
        return glass(data_in)

    rep.annotators.register(
        name=name,
        annotator=rep.annotators.augment_compose(
            source_annotator=rep.annotators.get("rgb", device="cpu"),
            augmentations=[rep.annotators.Augmentation.from_function(behind_glass)],
        ),
    )
    return glass

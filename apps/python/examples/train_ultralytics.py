"""Cracked glass in the training of an Ultralytics model, by its list of Albumentations transforms.

Ultralytics composes the list itself, seeds it in each worker, and hands over images in BGR; of its own
augmentations mosaic comes first, so that without `mosaic=0.0` the glass is in front of four scenes.
"""

import sys

import numpy as np
from starbreak.albumentations import CrackedGlass


class CrackedGlassBgr(CrackedGlass):
    """For images whose channels are blue, green, red."""

    def apply(self, img, **params):
        return np.ascontiguousarray(super().apply(img[..., ::-1], **params)[..., ::-1])


def train(model, data, bank, **words):
    """As `model.train(data=data, …)`, half of all images behind cracks out of a bank."""
    glass = CrackedGlassBgr(bank=bank, p=0.5)
    return model.train(data=data, augmentations=[glass], mosaic=0.0, **words)


if __name__ == "__main__":
    from ultralytics import YOLO

    train(YOLO("yolo11n.pt"), data=sys.argv[1], bank=sys.argv[2], epochs=10)

"""Cracked glass in the training of an Ultralytics model, by its list of Albumentations transforms.

Ultralytics composes the list itself, seeds it in each worker, and hands over images in BGR; of its own
augmentations mosaic comes first, so that without `mosaic=0.0` the glass is in front of four scenes.

Needs Albumentations 2.0.8. Where Ultralytics cannot compose a list, as with AlbumentationsX, it says so
in its log and trains without it; that is refused here.
"""

import sys

import numpy as np
from starbreak.albumentations import CrackedGlass


class CrackedGlassBgr(CrackedGlass):
    """For images whose channels are blue, green, red."""

    def apply(self, img, **params):
        return np.ascontiguousarray(super().apply(img[..., ::-1], **params)[..., ::-1])


def refuse_dropped(trainer):
    """Ends a training whose images would all be spared."""
    for step in trainer.train_loader.dataset.transforms.transforms:
        if type(step).__name__ == "Albumentations" and step.transform is None:
            raise RuntimeError("Ultralytics dropped the cracked glass, its log says why; install albumentations==2.0.8")


def train(model, data, bank, **words):
    """As `model.train(data=data, …)`, half of all images behind cracks out of a bank."""
    glass = CrackedGlassBgr(bank=bank, p=0.5)
    model.add_callback("on_train_start", refuse_dropped)
    return model.train(data=data, augmentations=[glass], mosaic=0.0, **words)


if __name__ == "__main__":
    from ultralytics import YOLO

    train(YOLO("yolo11n.pt"), data=sys.argv[1], bank=sys.argv[2], epochs=10)

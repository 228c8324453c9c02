"""Cracked glass as a transform of torchvision (v2).

Images are PIL images, ``tv_tensors.Image`` or uint8 tensors of shape (…, 1 or 3, H, W); boxes, masks
and labels pass through: glass moves no object.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

try:
    import PIL.Image
    import torch
    from torchvision import tv_tensors
    from torchvision.transforms import v2
    from torchvision.transforms.v2._utils import is_pure_tensor
except ImportError as error:
    raise ImportError("starbreak.torchvision needs torch and torchvision: pip install torchvision") from error

from ._drawing import CrackDrawing, seed_of_image

__all__ = ["CrackedGlass"]

_IMAGES = (PIL.Image.Image, tv_tensors.Image, tv_tensors.Video)


class CrackedGlass(v2.Transform):
    """The glass in front of the camera is broken.

    Args:
        recipe, severity, bank, p: as of :class:`starbreak.albumentations.CrackedGlass`.
        crack_seed: with it, the crack depends on this seed, the epoch and the pixels alone, and is the
            same for any number of workers. Without it cracks are drawn from torch's random numbers,
            which a ``DataLoader`` seeds in each worker.

    All images of one call stand behind one crack.
    """

    _transformed_types = (is_pure_tensor, *_IMAGES)

    def __init__(
        self,
        recipe: str | dict[str, Any] | None = None,
        severity: int | Sequence[int] | None = None,
        bank: str | None = None,
        crack_seed: int | None = None,
        p: float = 0.5,
    ) -> None:
        if not 0.0 <= p <= 1.0:
            raise ValueError(f"p {p}: expected 0 to 1")
        self.drawing = CrackDrawing(recipe, severity, bank)
        super().__init__()
        self.crack_seed = crack_seed
        self.p = p
        self.epoch = 0

    def set_epoch(self, epoch: int) -> None:
        """Draws other cracks from now on, the same for the same number; before workers start."""
        self.epoch = int(epoch)

    def make_params(self, flat_inputs: list[Any]) -> dict[str, Any]:
        if self.crack_seed is None:
            seed = int(torch.randint(2**63 - 1, ()).item())
        else:
            first = next(item for item in flat_inputs if isinstance(item, _IMAGES) or is_pure_tensor(item))
            seed = seed_of_image(self.crack_seed, self.epoch, None, _frames(first)[0])
        return {"seed": seed, "is_broken": self.drawing.is_drawn(seed, self.p)}

    def transform(self, inpt: Any, params: dict[str, Any]) -> Any:
        if not params["is_broken"]:
            return inpt
        frames = _frames(inpt)
        cracked = np.stack([self.drawing.crack(frame, params["seed"]) for frame in frames])
        if isinstance(inpt, PIL.Image.Image):
            return PIL.Image.fromarray(cracked[0])
        tensor = torch.from_numpy(cracked.reshape(len(frames), *frames.shape[1:3], -1))
        return tv_tensors.wrap(tensor.permute(0, 3, 1, 2).reshape(inpt.shape), like=inpt)


def _frames(image: Any) -> np.ndarray:
    """The frames of an image or video, N×H×W or N×H×W×3."""
    if isinstance(image, PIL.Image.Image):
        return np.asarray(image)[np.newaxis]
    frames = image.reshape(-1, *image.shape[-3:]).permute(0, 2, 3, 1).numpy()
    return frames[..., 0] if frames.shape[-1] == 1 else frames

"""Broken glass as a transform for torchvision (v2).

Images are PIL images, ``tv_tensors.Image``, ``tv_tensors.Video`` or uint8 tensors of shape
(…, 1 or 3, H, W). Boxes, masks and labels pass through, since glass moves no object; beside a
recipe with ``[distortion]``, which does, boxes, masks and key points are refused.

>>> import torch
>>> from starbreak.torchvision import CrackedGlass
>>> transform = CrackedGlass("paper", crack_seed=7, p=1.0)
>>> transform(torch.full((3, 120, 200), 128, dtype=torch.uint8)).shape
torch.Size([3, 120, 200])
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
except ImportError as error:
    raise ImportError("starbreak.torchvision needs torch and torchvision: pip install torchvision") from error

from ._drawing import CrackDrawing, Image, Path, RecipeLike, Severity, collected_region, whole

__all__ = ["CameraFault", "CrackedGlass"]


#: What names places of an image; older versions have no key points.
_PLACES = tuple(
    getattr(tv_tensors, name) for name in ("BoundingBoxes", "KeyPoints", "Mask") if hasattr(tv_tensors, name)
)


def _is_plain_tensor(value: Any) -> bool:
    return isinstance(value, torch.Tensor) and not isinstance(value, tv_tensors.TVTensor)


class CrackedGlass(v2.Transform):  # type: ignore[misc]
    """Break the glass in front of the camera.

    Args:
        recipe, severity, bank: as for :class:`starbreak.transforms.CrackedGlass`.
        crack_seed: with it, an image's crack, and whether it has one, depend only on this seed, the
            epoch (:meth:`set_epoch`) and the pixels, and are the same for any number of workers.
            Without it cracks are drawn from torch's random numbers, which a ``DataLoader`` seeds in
            each worker.
        region_key: for samples that are dicts: name under which the result has the region mask, a
            ``tv_tensors.Mask`` of H×W, 255 where pixels are affected.
        p: probability.

    All images of one call are behind one crack.

    Raises:
        ValueError: at construction for invalid parameters; later for images that are not uint8, and
            for boxes, masks and key points beside ``[distortion]``.
        OSError: for a bank that cannot be read.
    """

    _transformed_types = (_is_plain_tensor, PIL.Image.Image, tv_tensors.Image, tv_tensors.Video)

    def __init__(
        self,
        recipe: RecipeLike | None = None,
        severity: Severity | None = None,
        bank: Path | None = None,
        crack_seed: int | None = None,
        region_key: str | None = None,
        p: float = 0.5,
    ) -> None:
        super().__init__()
        if crack_seed is not None:
            crack_seed = whole("crack_seed", crack_seed, 0, 2**64 - 1)
        self._drawing = CrackDrawing(recipe, severity, bank, p, crack_seed)
        self.region_key = region_key

    def set_epoch(self, epoch: int) -> None:
        """Draw different cracks for each epoch number; call it before workers start."""
        self._drawing.epoch = epoch

    def extra_repr(self) -> str:
        return self._drawing.words(crack_seed=self._drawing.seed, region_key=self.region_key)

    def check_inputs(self, flat_inputs: list[Any]) -> None:
        if any(isinstance(value, _PLACES) for value in flat_inputs):
            self._drawing.refuse_moved("boxes, masks and key points")

    def make_params(self, flat_inputs: list[Any]) -> dict[str, Any]:
        if self._drawing.seed is None or not flat_inputs:
            seed = int(torch.randint(2**53, ()).item())
        else:
            seed = self._drawing.seed_of(_frames(flat_inputs[0])[0])
        return {"seed": seed}

    def transform(self, inpt: Any, params: dict[str, Any]) -> Any:
        frames = _frames(inpt)
        cracked = self._drawing.crack_or_spare(frames, params["seed"])
        if cracked is frames:
            return inpt
        if isinstance(inpt, PIL.Image.Image):
            return PIL.Image.fromarray(cracked[0])
        channels_last = cracked[0][np.newaxis] if len(cracked) == 1 else np.stack(cracked)
        tensor = torch.from_numpy(channels_last).permute(0, 3, 1, 2).reshape(inpt.shape)
        return tv_tensors.wrap(tensor, like=inpt) if isinstance(inpt, tv_tensors.TVTensor) else tensor

    def forward(self, *inputs: Any) -> Any:
        with collected_region(self.region_key is not None) as regions:
            result = super().forward(*inputs)
        if self.region_key is None:
            return result
        if not isinstance(result, dict):
            raise ValueError("region_key is for samples that are dicts; pass a dict, or leave it out")
        if self.region_key in result:
            raise ValueError(f"region_key {self.region_key!r}: the sample has this already; choose another name")
        return {**result, self.region_key: tv_tensors.Mask(regions[0])} if regions else result


def _frames(image: Any) -> Sequence[Image]:
    """The frames of an image or video, each H×W or H×W×C."""
    if isinstance(image, PIL.Image.Image):
        if image.mode not in ("RGB", "L"):
            raise ValueError(f"PIL image of mode {image.mode!r}: convert it to 'RGB' or 'L'")
        return [np.asarray(image)]
    if image.ndim < 3:
        raise ValueError(f"tensor of shape {tuple(image.shape)}: expected (…, 1 or 3, H, W)")
    return list(image.reshape(-1, *image.shape[-3:]).permute(0, 2, 3, 1).numpy())


#: The same under the name of what it does with presets such as ``noise``.
CameraFault = CrackedGlass

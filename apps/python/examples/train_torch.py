"""A training loop in torch whose images are behind broken glass; boxes stay as they are.

Needs torch and torchvision. The network and the pictures are as small as they get: replace both.
"""

import torch
from starbreak.torchvision import CrackedGlass
from torch.utils.data import DataLoader, Dataset
from torchvision import tv_tensors
from torchvision.transforms import v2


class Squares(Dataset):
    """A bright square in noise, and where it is."""

    def __init__(self, transform, n=64):
        self.transform, self.n = transform, n

    def __len__(self):
        return self.n

    def __getitem__(self, idx):
        random = torch.Generator().manual_seed(idx)
        x, y = torch.randint(0, 96, (2,), generator=random).tolist()
        image = torch.randint(0, 120, (3, 128, 128), generator=random, dtype=torch.uint8)
        image[:, y : y + 32, x : x + 32] = 220
        box = tv_tensors.BoundingBoxes([[x, y, x + 32, y + 32]], format="XYXY", canvas_size=(128, 128))
        image, box = self.transform(tv_tensors.Image(image), box)
        return image, box[0] / 128


def train(n_epochs=3):
    """The mean loss of each epoch."""
    torch.manual_seed(0)
    glass = CrackedGlass("paper", severity=(1, 3), crack_seed=7, p=0.5)
    transform = v2.Compose([glass, v2.ToDtype(torch.float32, scale=True)])
    loader = DataLoader(Squares(transform), batch_size=8, num_workers=2)
    network = torch.nn.Sequential(
        torch.nn.Conv2d(3, 8, 5, stride=4), torch.nn.ReLU(), torch.nn.Flatten(), torch.nn.LazyLinear(4)
    )
    network(torch.zeros(1, 3, 128, 128))
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)
    losses = []
    for epoch in range(n_epochs):
        glass.set_epoch(epoch)  # before the loader starts its workers
        total = 0.0
        for images, boxes in loader:
            loss = torch.nn.functional.l1_loss(network(images), boxes)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            total += loss.item()
        losses.append(total / len(loader))
    return losses


if __name__ == "__main__":
    print(train())

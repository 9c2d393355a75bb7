"""Codes of maps by an autoencoder: what a network finds in maps that knows nothing of transfer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import nn

from gcm_learn.recall import PcaIndex, Waypoints, map_picture, nearest_rows, raw_features
from gcm_learn.scene.packing import Scene
from gcm_learn.situation import Situation

WIDTH, EPOCHS, BATCH, RATE = 256, 30, 64, 1e-3


@dataclass(frozen=True)
class AutoencoderIndex:
    """As `PcaIndex`, with the codes of an autoencoder of as many numbers in place of components."""

    encoder: nn.Sequential
    regression: PcaIndex
    """Predicts a query's code from its raw parameters."""
    name = "autoencoder"
    key = "autoencoder"
    dim = PcaIndex.most + 1

    @classmethod
    def fit(cls, situations: Sequence[Situation], seed: int = 0) -> AutoencoderIndex:
        """Train on the situations' maps; then fit the regression from raw parameters to codes."""
        regression = PcaIndex.fit(situations, seed)
        pictures = np.array([map_picture(s) for s in situations])
        encoder = _trained(torch.from_numpy(pictures - regression.centre), seed)
        codes = _codes(encoder, pictures - regression.centre)
        raw = np.array([raw_features(s) for s in situations])
        return cls(encoder, regression.predicting(codes, raw))

    def embed_query(self, situation: Situation, scene: Scene | None = None) -> np.ndarray:
        """Return the probable place of the map of a situation."""
        return self.regression.embed_query(situation, scene)

    def embed_memories(
        self, situations: Sequence[Situation], traces: Sequence[Waypoints]
    ) -> np.ndarray:
        """Return the places of the maps of memories."""
        pictures = np.array([map_picture(s) for s in situations])
        return nearest_rows(_codes(self.encoder, pictures - self.regression.centre))


def _codes(encoder: nn.Sequential, pictures: np.ndarray) -> np.ndarray:
    with torch.no_grad():
        codes: np.ndarray = encoder(torch.from_numpy(pictures)).numpy()
    return codes


def _trained(pictures: torch.Tensor, seed: int) -> nn.Sequential:
    """The first half of a network that learned to draw the pictures (n, m) again."""
    size = pictures.shape[1]
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        encoder = nn.Sequential(nn.Linear(size, WIDTH), nn.ReLU(), nn.Linear(WIDTH, PcaIndex.most))
        decoder = nn.Sequential(nn.Linear(PcaIndex.most, WIDTH), nn.ReLU(), nn.Linear(WIDTH, size))
        net = nn.Sequential(encoder, decoder)
        optimiser = torch.optim.Adam(net.parameters(), RATE)
        for _ in range(EPOCHS):
            for rows in torch.randperm(len(pictures)).split(BATCH):
                loss = nn.functional.mse_loss(net(pictures[rows]), pictures[rows])
                optimiser.zero_grad()
                loss.backward()
                optimiser.step()
        with torch.no_grad():
            left = nn.functional.mse_loss(net(pictures), pictures) / pictures.square().mean()
    print(f"autoencoder: {float(left):.1%} of the maps' variance left", flush=True)
    return encoder

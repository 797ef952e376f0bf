"""Which past frames look like this one: vectors of locally aggregated descriptors (VLAD, Jegou 2010)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

WORDS = 48
SAMPLE = 12000  # descriptors that the words are learnt from


class Album:
    """The frames seen so far, one vector each."""

    def __init__(self, words: np.ndarray):
        self.words = words.astype(np.float32)  # (k, 128)
        self.vectors = np.empty((0, words.size), np.float32)
        self.keys: list[int] = []

    def vector(self, descriptors: np.ndarray) -> np.ndarray:
        """The signature of a picture: residuals to the nearest words, normalised a word and as a whole."""
        d = descriptors.astype(np.float32)
        nearest = (d @ self.words.T - 0.5 * np.square(self.words).sum(axis=1)).argmax(axis=1)
        member = (nearest[:, None] == np.arange(len(self.words))).astype(np.float32)
        total = member.T @ d - member.sum(axis=0)[:, None] * self.words  # sums of bytes: exact in float32
        total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-9)
        return (total / max(float(np.linalg.norm(total)), 1e-9)).ravel()

    def add(self, key: int, vector: np.ndarray) -> None:
        """Keep a frame under a number."""
        if len(self.keys) == len(self.vectors):  # grow by half
            room = np.zeros((max(64, len(self.vectors) // 2), self.words.size), np.float32)
            self.vectors = np.concatenate([self.vectors, room])
        self.vectors[len(self.keys)] = vector
        self.keys.append(key)

    def similar(self, vector: np.ndarray, count: int) -> list[int]:
        """Numbers of the frames most alike, the best first."""
        scores = self.vectors[: len(self.keys)] @ vector
        return [self.keys[k] for k in np.argsort(-scores, kind="stable")[:count]]


def learn_words(descriptors: Sequence[np.ndarray], rng: np.random.Generator) -> np.ndarray:
    """k-means (8 rounds of Lloyd's) of descriptors (n, 128) of some frames; (WORDS, 128) float64."""
    data = np.concatenate(descriptors).astype(np.float32)
    if len(data) < WORDS:
        data = np.concatenate([data, rng.uniform(0, 60, (WORDS, 128)).astype(np.float32)])
    data = data[rng.permutation(len(data))[:SAMPLE]]
    words = data[:WORDS].copy()
    for _ in range(8):
        nearest = (data @ words.T - 0.5 * np.square(words).sum(axis=1)).argmax(axis=1)
        counts = np.bincount(nearest, minlength=WORDS)
        total = np.zeros_like(words)
        np.add.at(total, nearest, data)
        words = np.where(counts[:, None] > 0, total / np.maximum(counts, 1)[:, None], words)
    return words.astype(np.float64)

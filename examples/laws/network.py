"""A small neural network in the translation slot, with its weights in a file beside it.

    skylimb run --controller examples/laws/network.toml
    python examples/laws/network.py             fits the network anew, to a PD law that cannot saturate

Each axis asks the same network, 2 inputs (error, rate) -> 16 tanh -> 1 output (acceleration). A row of
network.csv is one neuron: its two weights, its bias, and its weight in the output.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

FILES = ("network.csv",)  # kept with every flight, and read anew when it has changed
WEIGHTS = Path(__file__).with_name("network.csv")
ERROR, RATE, BIAS, OUT = np.loadtxt(WEIGHTS, delimiter=",").T


@dataclass(frozen=True)
class Gains:
    share: float = 1.0  # of what the network says


def initial_state(gains, start):
    return ()


def step(gains, state, inputs):
    body, reference = inputs.estimate.body, inputs.reference
    error, rate = body.position - reference.position, body.velocity - reference.velocity
    neurons = zip(ERROR, RATE, BIAS, OUT, strict=True)
    said = sum(out * np.tanh(e * error + r * rate + bias) for e, r, bias, out in neurons)
    return state, body.model.mass * (gains.share * said + body.model.gravity), {"network": said}


def fit():
    rng = np.random.default_rng(0)
    error, rate = rng.uniform(-0.5, 0.5, (2, 4000))
    taught = -3.0 * np.tanh(4.0 / 3.0 * error + 4.0 / 3.0 * rate)
    hidden = rng.uniform(-2.0, 2.0, (16, 3)) * [1.0, 1.0, 0.5]
    hidden[8:] = -hidden[:8] * [1.0, 1.0, -1.0]  # in pairs, as it has no preferred side
    made = np.tanh(hidden @ [error, rate, np.ones(4000)])
    pairs = made[:8] - made[8:]
    out = np.linalg.solve(pairs @ pairs.T + 1e-3 * np.eye(8), pairs @ taught)
    np.savetxt(WEIGHTS, np.column_stack([hidden, np.concatenate([out, -out])]), "%.6f", delimiter=",")
    print("off by at most", np.abs(out @ pairs - taught).max(), "m/s^2")


if __name__ == "__main__":
    fit()

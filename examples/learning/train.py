"""Trains the residual of residual.py with PPO, and draws how it went.

    pip install "skylimb[train]"
    python examples/learning/train.py out/learning              some 20 minutes on two cores
    python examples/learning/train.py out/learning              the same again: goes on where it was killed
    skylimb run --controller examples/learning/residual.toml    flies what it wrote, policy.json

A round of the training depends on nothing but the weights before it and its number: each begins with seeds
of its own and flights that take off. So a training that was killed, and goes on from its last round, ends
with the same weights as one that was not.
"""

# pyright: reportMissingImports=false

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

import numpy as np
import torch
from residual import POLICY, policy_text
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.utils import set_random_seed
from stable_baselines3.common.vec_env import VecEnv

from skylimb import envs
from skylimb.base.files import replace_text, replacing

HERE, EPOCHS = Path(__file__).parent, 5
SETTINGS: dict[str, Any] = {
    "task": "sliding",
    "controller": str(HERE / "residual.toml"),
    "actions": "gains",
    "gains": {"translation.offset": (-0.02, 0.02)},
    "observations": "signals",
    "signals": ("policy_observation",),
    "rewards": {"on_path": 0.1, "press": 0.05, "smooth": 0.002, "lost": 5.0},
    "vary": {
        "controller.translation.share": {"choice": [0.0]},
        "surface.friction": {"uniform": [0.1, 0.6]},
        "surface.slope": {"uniform": [-0.35, 0.35]},
        "plant.thrust_scale": {"normal": [1.0, 0.02], "within": [0.95, 1.05]},
    },
    "draws": 32,
}


class Flights(VecEnv):
    """A fleet as stable-baselines3 knows environments: what ends begins anew in the same step."""

    def __init__(self, count: int, threads: int) -> None:
        self.fleet = envs.Fleet(count, threads, **SETTINGS)
        size = (self.fleet.observed,), (len(self.fleet.actions.names),)
        super().__init__(count, *_boxes(*size))
        self.random = np.random.default_rng(0)
        self.actions = np.zeros((count, *size[1]))

    def reset(self) -> np.ndarray:
        return self._begin(np.arange(self.num_envs))

    def _begin(self, places: np.ndarray) -> np.ndarray:
        draws = self.random.integers(self.fleet.settings.draws, size=len(places))
        return self.fleet.restart(places.tolist(), draws.tolist()).astype(np.float32)

    def step_async(self, actions: np.ndarray) -> None:
        self.actions = actions

    def step_wait(self) -> Any:
        done = self.fleet.step(np.arange(self.num_envs), self.actions)
        shown, ended = done.observations.astype(np.float32), done.lost | done.over
        told = {name: term.mean() for name, term in done.terms.items()}
        infos: list[dict[str, Any]] = [{"terms": told} for _ in range(self.num_envs)]
        for place in np.flatnonzero(ended):
            infos[place] |= {
                "terminal_observation": shown[place],
                "TimeLimit.truncated": bool(done.over[place]),
            }
        if ended.any():
            shown[ended] = self._begin(np.flatnonzero(ended))
        return shown, done.rewards.astype(np.float32), ended, infos

    def close(self) -> None: ...

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self, attr_name, None)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **named: Any) -> list[Any]:
        raise NotImplementedError

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * self.num_envs


class Means(BaseCallback):
    """Keeps the mean of reward and terms of a round."""

    def _on_rollout_start(self) -> None:
        self.told: list[dict[str, float]] = []

    def _on_step(self) -> bool:
        terms = self.locals["infos"][0]["terms"]
        self.told.append({"reward": float(self.locals["rewards"].mean()), **terms})
        return True


def train(out: Path, rounds: int, count: int = 8, steps: int = 1024, threads: int = 2) -> None:
    """Train for some rounds, of which those that `out` has are not trained again."""
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    out.mkdir(parents=True, exist_ok=True)
    kept, curve = out / "training.zip", out / "curve.csv"
    flights = Flights(count, threads)
    network: dict[str, Any] = {"net_arch": [32, 32], "log_std_init": -1.0}
    shape: dict[str, Any] = {
        "n_steps": steps,
        "batch_size": 1024,
        "n_epochs": EPOCHS,
        "gamma": 0.98,
        "device": "cpu",
    }
    model = PPO("MlpPolicy", flights, policy_kwargs=network, seed=0, **shape)
    rows: list[dict[str, Any]] = []
    if kept.is_file():
        model = PPO.load(kept, flights, device="cpu")
        rows = list(csv.DictReader(curve.read_text("utf-8").splitlines()))[: model._n_updates // EPOCHS]
    for number in range(len(rows), rounds):
        set_random_seed(number)
        flights.random = np.random.default_rng([7, number])
        model._last_obs, means = None, Means()
        model.learn(count * steps, callback=means, reset_num_timesteps=False)
        found = {name: np.mean([one[name] for one in means.told]) for name in means.told[0]}
        rows.append({"round": number, **{name: f"{value:.5f}" for name, value in found.items()}})
        table = [",".join(rows[0]), *(",".join(map(str, row.values())) for row in rows)]
        # The curve first: a round that the weights do not know of is trained again.
        replace_text(curve, "\n".join(table) + "\n")
        with replacing(kept) as aside, aside.open("wb") as file:
            model.save(file)
        print(f"round {number + 1} of {rounds}: reward {found['reward']:.3f} a step", flush=True)
    replace_text(out / POLICY.name, policy_text(flights.fleet.start(0)[1].robot.name, layers(model)))
    draw(rows, out / "curve.png")


def layers(model: PPO) -> list[tuple[np.ndarray, np.ndarray]]:
    """Weights and biases of what the policy does at its mean."""
    policy = model.policy
    found = [*policy.mlp_extractor.policy_net, policy.action_net]
    linear = [one for one in found if isinstance(one, torch.nn.Linear)]
    return [
        (one.weight.detach().numpy().astype(float), one.bias.detach().numpy().astype(float)) for one in linear
    ]


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """Reward and its terms, round by round."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7.0, 3.2), layout="constrained")
    rounds = [int(row["round"]) + 1 for row in rows]
    for name in (name for name in rows[0] if name not in ("round", "lost", "smooth")):
        axes.plot(
            rounds, [float(row[name]) for row in rows], label=name, linewidth=2.0 if name == "reward" else 1.0
        )
    axes.set(xlabel="round of training", ylabel="mean of a step")
    axes.legend()
    with replacing(path) as aside:
        figure.savefig(aside, format="png", dpi=120)


def _boxes(seen: tuple[int, ...], done: tuple[int, ...]) -> tuple[Any, Any]:
    from gymnasium.spaces import Box

    return Box(-np.inf, np.inf, seen, np.float32), Box(-1.0, 1.0, done, np.float32)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--rounds", type=int, default=31)
    asked = parser.parse_args()
    train(asked.out, asked.rounds)
    replace_text(POLICY, (asked.out / POLICY.name).read_text("utf-8"))


if __name__ == "__main__":
    main()

"""The page of `behaviours`: what the mixtures found, drawn as poses, how many, and whether the chains can be
trusted.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit import curves
from ipcli.report.kit import provenance as origin
from ipcli.report.kit.numbers import number, percent
from ipcli.report.kit.page import Markup, details, element, notice, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.skeleton import bounds, pose_figure
from ipcli.report.mocap.action_evaluation import clusters

MOST = 8  # behaviours of a group that are drawn
TRUSTED = 1.1  # largest R-hat of chains that agree
TRACES = 4  # cells whose traces are drawn: those that agree least


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = 0) -> str:
    """The HTML of a `behaviours` artefact; its figures are drawn, so there is nothing for ``widest`` to bound."""
    actions, groups = arrays["actions"], arrays["groups"]
    doubtful = int((arrays["r_hat"] > TRUSTED).sum())
    cells = len(actions) * len(groups)
    text = (
        f"the number of behaviours of {doubtful} of {cells} mixtures has not settled (R-hat above {TRUSTED}). "
        "Recognition does not need it "
        "to; for numbers to rely on give more sweeps and chains: --set learning.mixture.sweeps=1000 --set "
        "learning.mixture.chains=4"
    )
    return document(
        f"Behaviours of {len(actions)} actions in {len(groups)} groups",
        "ipcli mocap-train",
        _verdict(arrays),
        *([notice(text)] if doubtful else []),
        _poses(arrays),
        clusters({"components": arrays["components"], "classes": actions, "groups": groups}),
        _preferences(arrays),
        _chains(arrays),
        origin.origin(provenance),
    )


def _verdict(arrays: Mapping[str, np.ndarray]) -> str:
    frames, mean = int(arrays["frames"].sum()), arrays["components"][..., 0]
    return (
        f"{frames} frames of {int(arrays['clips'].sum())} clips by {len(arrays['actors'])} people; {mean.min():.0f} to "
        f"{mean.max():.0f} behaviours "
        f"for an action in a group, {mean.mean():.1f} on average."
    )


def _poses(arrays: Mapping[str, np.ndarray]) -> Markup:
    """A block an action, a row a group: its most frequent behaviours (thesis figure 5.6)."""
    box = bounds([arrays["behaviour_poses"]])
    blocks = [_action(arrays, a, box) for a in range(len(arrays["actions"]))]
    lead = (
        "Each behaviour by the frame that is most typical of it, from the front and from the right; in colour the "
        "group, faint the group in "
        "other frames of the same behaviour. Behaviours are in order of the share of the action's frames."
    )
    return section("Behaviours as poses", *blocks, lead=lead)


def _action(arrays: Mapping[str, np.ndarray], action: int, box: tuple[np.ndarray, np.ndarray]) -> Markup:
    rows = []
    for group, name in enumerate(map(str, arrays["groups"])):
        count = len(_ranked(arrays, action, group))
        more = f", {count - MOST} more are rarer" if count > MOST else ""
        rows += [element("h3", f"{name}: {count} behaviours{more}"), behaviours(arrays, action, group, box, MOST)]
    block = details(str(arrays["actions"][action]), *rows)
    return Markup(block.replace("<details>", "<details open>", 1)) if action == 0 else block


def behaviours(
    arrays: Mapping[str, np.ndarray], action: int, group: int, box: tuple[np.ndarray, np.ndarray], most: int
) -> Markup:
    """The most frequent behaviours of an action in a group, drawn in a row."""
    ranked = enumerate(_ranked(arrays, action, group)[:most], start=1)
    return element("div", *(_behaviour(arrays, index, rank, group, box) for rank, index in ranked), class_="poses")


def _ranked(arrays: Mapping[str, np.ndarray], action: int, group: int) -> np.ndarray:
    mine = np.flatnonzero((arrays["behaviour_action"] == action) & (arrays["behaviour_group"] == group))
    return mine[np.argsort(-arrays["behaviour_share"][mine], kind="stable")]


def _behaviour(
    arrays: Mapping[str, np.ndarray], index: int, rank: int, group: int, box: tuple[np.ndarray, np.ndarray]
) -> Markup:
    poses = [pose for pose in arrays["behaviour_poses"][index] if np.isfinite(pose).any()]
    share = percent(float(arrays["behaviour_share"][index]))
    picked = np.full(len(arrays["parents"]), str(arrays["groups"][group]) in ("body", "motion"))
    picked[arrays["group_members"][arrays["group_members"][:, 0] == group, 1]] = True
    return pose_figure(poses, arrays["parents"], picked, f"{rank}", share, box=box)


def _preferences(arrays: Mapping[str, np.ndarray]) -> Markup:
    """The preference matrix W of (5.12)."""
    rows = [
        (str(name), *(percent(float(share)) for share in line))
        for name, line in zip(arrays["actions"], arrays["preferences"], strict=True)
    ]
    best = {(row, int(line.argmax()) + 1) for row, line in enumerate(arrays["preferences"])}
    lead = "How much each group counts for each action by --rule preferences (W of 5.12); the strongest in bold."
    return section("Preferences", table(("Action", *map(str, arrays["groups"])), rows, bold=best), lead=lead)


def _chains(arrays: Mapping[str, np.ndarray]) -> Markup:
    """Traces of the number of clusters where the chains agree least, and the diagnostics of all."""
    r_hat, ess = arrays["r_hat"], arrays["ess"]
    worst = np.argsort(-r_hat, axis=None, kind="stable")[:TRACES]
    cells = [np.unravel_index(index, r_hat.shape) for index in worst]
    plots = [_trace(arrays, int(a), int(g)) for a, g in cells]
    rows = []
    for a, name in enumerate(map(str, arrays["actions"])):
        rows.append((name, *(f"{number(r_hat[a, g], 3)}, {ess[a, g]:.0f}" for g in range(r_hat.shape[1]))))
    chains, sweeps = arrays["trace_clusters"].shape[:2]
    many = f"{chains} chains of {sweeps} sweeps each" if chains > 1 else f"One chain of {sweeps} sweeps"
    lead = (
        f"{many}. Above, the number of clusters along the sweeps of the mixtures that have settled least; below, R-hat "
        "(1 when the halves of all "
        "chains agree) and the effective number of independent draws, both of the number of clusters."
    )
    diagnostics = details(
        "R-hat and effective draws of every mixture", table(("Action", *map(str, arrays["groups"])), rows)
    )
    return section("Chains", element("div", *plots, class_="plots"), diagnostics, lead=lead)


def _trace(arrays: Mapping[str, np.ndarray], action: int, group: int) -> Markup:
    clusters = arrays["trace_clusters"][:, :, action, group]
    sweeps = np.arange(1, clusters.shape[1] + 1)
    lines = [curves.Series(f"chain {index}", sweeps, chain) for index, chain in enumerate(clusters, start=1)]
    title = f"{arrays['actions'][action]}, {arrays['groups'][group]}: R-hat {number(arrays['r_hat'][action, group], 3)}"
    return curves.plot(lines, title, "sweep", "clusters", from_zero=True, width=420, height=260)

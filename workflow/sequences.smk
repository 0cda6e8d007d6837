# The sequences: those that the configuration names, or those of a data set as `occluscope sweep --dataset` finds them.

import json
import os
import re
from typing import NamedTuple

from snakemake.exceptions import WorkflowError


class Sequence(NamedTuple):
    video: str
    truth: str
    # Whether the ground truth is of masks.
    has_masks: bool


def sequences(config):
    """The sequences by name. Names of a data set are paths below its folder, such as `category/sequence`."""
    named, root = config.get("sequences") or {}, config.get("dataset")
    if bool(named) == bool(root):
        raise WorkflowError("the configuration needs either `sequences` or `dataset`")
    if named:
        missing = [name for name, files in named.items() if {"video", "truth"} - set(files or {})]
        if missing:
            raise WorkflowError(f"sequence {missing[0]} in the configuration needs `video` and `truth`")
        found = {name: sequence(files["video"], files["truth"]) for name, files in named.items()}
    else:
        found = dict(sequences_of_dataset(root))
        if not found:
            layouts = "input/ and groundtruth/, img1/ and gt/gt.txt, or a scene of `synth`"
            raise WorkflowError(f"{root} has no sequences, folders with {layouts}; check `dataset` in the configuration")
    odd = [name for name in found if not re.fullmatch(r"[\w+-][\w.+-]*(/[\w+-][\w.+-]*)*", str(name), re.ASCII)]
    if odd:
        raise WorkflowError(f"sequence {odd[0]!r}: names have letters, digits and ._+- only, and begin with no point; rename it")
    return {str(name): sequence for name, sequence in found.items()}


def sequence(video, truth):
    return Sequence(video, truth, has_masks(truth))


def has_masks(truth):
    if not os.path.isdir(truth):
        return False
    # The folder of a scene, then that of a MOTChallenge sequence.
    for folder in (os.path.join(truth, "truth"), truth, os.path.join(truth, "gt")):
        if os.path.isfile(os.path.join(folder, "gt.txt")):
            return os.path.isdir(os.path.join(folder, "identities"))
    return True


def sequences_of_dataset(root):
    for folder, folders, _ in os.walk(root, followlinks=True):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        found = sequence_at(folder)
        if found:
            folders.clear()
            name = os.path.relpath(folder, root)
            yield os.path.basename(os.path.abspath(root)) if name == "." else name, found


def sequence_at(folder):
    here = lambda *names: os.path.join(folder, *names)
    if os.path.isdir(here("input")) and os.path.isdir(here("groundtruth")):
        return sequence(folder, folder)
    if os.path.isdir(here("img1")) and os.path.isfile(here("gt", "gt.txt")):
        return sequence(folder, here("gt", "gt.txt"))
    if os.path.isfile(here("scene.json")) and os.path.isfile(here("truth", "gt.txt")):
        with open(here("scene.json")) as scene:
            return sequence(here(json.load(scene)["video"]), folder)
    return None

"""What `import curiosight` gives, and what it does not wait for."""

from __future__ import annotations

import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import curiosight
from curiosight import DataError
from curiosight.errors import printable
from recordings import write_folder


def test_every_public_name_is_there_and_listed() -> None:
    assert set(curiosight.__all__) <= set(dir(curiosight))
    for name in curiosight.__all__:
        assert callable(getattr(curiosight, name))
    for name in ("open_datasets", "_hidden", "no.name"):
        assert not hasattr(curiosight, name)


@pytest.mark.parametrize(
    "first",
    [
        "import curiosight.explore",
        "from curiosight.explore import Step",
        "import curiosight.experiments.exploring",
        "import curiosight",
    ],
)
def test_explore_is_the_function_whatever_is_imported_first(first: str) -> None:
    program = (
        f"{first}; import curiosight; from curiosight import *; print(explore.__name__, "
        "curiosight.explore is explore, curiosight.datasets.open_dataset.__module__)"
    )
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "explore True curiosight.datasets\n"


def test_open_dataset_takes_what_the_commands_take(tmp_path: Path) -> None:
    write_folder(tmp_path / "recording", 2)
    assert len(curiosight.open_dataset(tmp_path / "recording")) == 2
    room = curiosight.open_dataset("room:7,views=3")
    assert len(room) == 3
    assert room.has_depth


def test_model_is_found_in_its_folder(tmp_path: Path) -> None:
    learner = curiosight.make_learner(curiosight.load_config("paper"), None)
    learner.save(tmp_path / "model.npz")
    rgb = np.zeros((60, 80, 3), np.uint8)
    for path in (tmp_path, str(tmp_path), tmp_path / "model.npz"):
        loaded = curiosight.SaliencyLearner.load(path)
        assert np.array_equal(loaded.saliency(rgb), learner.saliency(rgb))
    (tmp_path / "empty").mkdir()
    with pytest.raises(DataError, match=r"holds no model\.npz; give the folder") as caught:
        curiosight.SaliencyLearner.load(tmp_path / "empty")
    assert caught.value.path == tmp_path / "empty"


def refuse(path: str) -> None:
    raise DataError(path, "is a file", "give a folder")


def test_data_error_crosses_processes_whole() -> None:
    for error in (
        pickle.loads(pickle.dumps(DataError("a//b", "is a file", "give a folder"))),
        raised_in_a_worker("a//b"),
    ):
        assert str(error) == "a//b: is a file; give a folder"
        assert (error.path, error.found) == (Path("a/b"), "is a file")
        assert error.remedy == "give a folder"


def raised_in_a_worker(path: str) -> DataError:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        with pytest.raises(DataError) as caught:
            pool.submit(refuse, path).result(timeout=60)
        return caught.value


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("plain – ü 漢", "plain – ü 漢"),
        ("red\x1b[31m", "red\\x1b[31m"),
        ("two\nlines\r", "two\\nlines\\r"),
        ("c1 \x9b2J", "c1 \\x9b2J"),
        ("turned \u202egnp", "turned \\u202egnp"),
        ("bytes \udcff", "bytes \\udcff"),
        ("wide\u3000blank", "wide\u3000blank"),
    ],
)
def test_names_do_nothing_to_a_terminal(name: str, shown: str) -> None:
    assert printable(name) == shown
    assert str(DataError(name, "is odd", "rename it")) == f"{shown}: is odd; rename it"

"""The node's services: save, load, reset, pause, freeze."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from curiosight.errors import DataError
from curiosight.experiments.ros.owner import Owner


class Services:
    """Private services of a configured node; each answers whether it was done, and in words."""

    def __init__(self, owner: Owner) -> None:
        self._owner = owner
        types = owner.ros.std_srvs_srv
        node = owner.node
        self._services = [
            node.create_service(types.Trigger, f"~/{name}", self._answering(job))
            for name, job in (("save", self._save), ("load", self._load), ("reset", self._reset))
        ] + [
            node.create_service(types.SetBool, f"~/{name}", self._switching(name))
            for name in ("pause", "freeze")
        ]

    def close(self) -> None:
        for service in self._services:
            self._owner.node.destroy_service(service)

    def _answering(self, job: Callable[[], str]) -> Callable[[Any, Any], Any]:
        def answer(_: Any, response: Any) -> Any:
            try:
                response.message, response.success = job(), True
            except (DataError, ValueError, OSError) as error:
                response.message, response.success = str(error), False
            return response

        return answer

    def _switching(self, name: str) -> Callable[[Any, Any], Any]:
        words = {
            "pause": ("goes on", "paused"),
            "freeze": ("learns again", "the model stays as it is"),
        }[name]

        def answer(request: Any, response: Any) -> Any:
            learning = self._owner.learning
            assert learning is not None
            for one in (learning, learning.watch):
                if one is not None:
                    setattr(one, {"pause": "is_paused", "freeze": "is_frozen"}[name], request.data)
            response.success, response.message = True, words[request.data]
            return response

        return answer

    def _save(self) -> str:
        learning = self._owner.learning
        assert learning is not None
        return f"saved to {learning.save()}"

    def _load(self) -> str:
        if self._owner.model is None:
            raise ValueError("model: expected the parameter to name a run, got an empty one")
        return self._replaced(is_new=False)

    def _reset(self) -> str:
        return self._replaced(is_new=True)

    def _replaced(self, *, is_new: bool) -> str:
        owner = self._owner
        learning = owner.learning
        assert learning is not None
        with owner.switching:
            is_running = learning.watch is not None
            if is_running:
                learning.halt()
            try:
                return learning.replace(None if is_new else owner.model)
            finally:  # with the old one, where there is no other
                if is_running:
                    owner.start()

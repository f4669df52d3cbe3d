"""The code of the studio's page that makes robots of images, in a process of Node.js."""

import base64
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from image_file import text_of

TOP = Path(__file__).parents[1]


class Page:
    """The page's code."""

    def __init__(self) -> None:
        node = shutil.which("node")
        if node is None or not (TOP / "studio/node_modules/esbuild").is_dir():
            pytest.skip("Node.js and the tools of the studio are not installed: run `make studio`")
        command = [node, str(TOP / "tests/hosts/studio_code.mjs")]
        self.node = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def _ask(self, ask: str, *given: Any) -> Any:
        assert self.node.stdin
        assert self.node.stdout
        self.node.stdin.write(json.dumps({"ask": ask, "with": given}) + "\n")
        self.node.stdin.flush()
        return json.loads(self.node.stdout.readline())

    def changed(self, image: bytes, factors: dict[str, float]) -> tuple[bytes, str, dict[str, Any]]:
        """Return the image, the file and the body in the text of a robot with factors on its body."""
        answer = self._ask("change", base64.b64encode(image).decode(), text_of(image), factors)
        return base64.b64decode(answer["image"]), answer["toml"], answer["body"]

    def samples(self, image: bytes, factors: dict[str, float]) -> list[bytes]:
        """Return the images of the samples of a fit or of estimates, with factors on the body."""
        made = self._ask("sample", base64.b64encode(image).decode(), text_of(image), factors)
        return [base64.b64decode(one) for one in made]

    def spread(
        self, samples: list[dict[str, float]], quantities: list[str], factors: list[float] | None = None
    ) -> dict[str, Any]:
        """Return where most of the samples of a gait lie; with factors of the speed, those of estimates."""
        answer: dict[str, Any] = self._ask("spread", samples, quantities, factors)
        return answer

    def close(self) -> None:
        """End the process."""
        assert self.node.stdin
        assert self.node.stdout
        self.node.stdin.close()
        self.node.wait()
        self.node.stdout.close()

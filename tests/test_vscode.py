"""The extension of VS Code, in Node with a VS Code that only remembers what it is asked for."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

EXTENSION = Path(__file__).parents[1] / "editors" / "vscode" / "extension.js"
NODE = shutil.which("node") or ""
pytestmark = pytest.mark.skipif(not NODE, reason="needs node")

#: Activates the extension, asks for two previews of a file, and ends when an address was opened.
ACTS = """
const Module = require("node:module");
const [extension, command, path, language, folder] = process.argv.slice(2);
const said = { opened: [], wrong: [] };
// what is said while it is ended counts too
const done = (then) => { then(); setTimeout(() => console.log(JSON.stringify(said)), 1500); };
const vscode = {
  workspace: { getConfiguration: () => ({ get: () => command }), workspaceFolders: [{ uri: { fsPath: folder } }] },
  ProgressLocation: { Window: 1 },
  window: {
    withProgress: (_, act) => act(),
    activeTextEditor: { document: { languageId: language, uri: { fsPath: path } } },
    showErrorMessage: (text) => { said.wrong.push(text); done(acts.deactivate); },
  },
  env: {
    openExternal: (to) => {
      said.opened.push(to);
      if (said.opened.length === 1) preview(); else done(acts.deactivate);
    },
  },
  Uri: { parse: (text) => text },
  commands: { registerCommand: (name, act) => { said.command = name; preview = act; } },
};
class LanguageClient {
  constructor(id, name, server) { said.server = [server.command, ...server.args]; }
  start() {}
  stop() {}
}
let preview;
const load = Module._load;
const stubs = { vscode, "vscode-languageclient/node": { LanguageClient } };
Module._load = (name, ...rest) => stubs[name] ?? load(name, ...rest);
const acts = require(extension);
acts.activate({ subscriptions: [] });
preview();
"""


def acted(tmp_path: Path, command: str, language: str = "pore") -> dict[str, object]:
    program = tmp_path / "part.pore"
    program.write_text("sphere(10)")
    (tmp_path / "acts.js").write_text(ACTS)
    asked = [NODE, str(tmp_path / "acts.js"), str(EXTENSION), command, str(program), language, str(tmp_path)]
    ended = subprocess.run(asked, capture_output=True, text=True, timeout=60)  # it ends: no process is left
    assert ended.returncode == 0, ended.stderr
    found: dict[str, object] = json.loads(ended.stdout.splitlines()[0])
    return found


def test_a_preview_is_the_page_of_the_file(tmp_path: Path) -> None:
    command = tmp_path / "pore"
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m porelang "$@"\n')
    command.chmod(0o755)
    said = acted(tmp_path, "${workspaceFolder}/pore")
    assert said["command"] == "pore.preview"
    assert said["server"] == [str(command), "lsp"]
    assert said["wrong"] == []
    first, second = said["opened"]  # type: ignore[misc]
    assert first == second  # one page of a file, opened again
    assert str(first).startswith("http://127.0.0.1:")


def test_what_is_missing_is_told(tmp_path: Path) -> None:
    (wrong,) = acted(tmp_path, str(tmp_path / "no" / "pore"))["wrong"]  # type: ignore[misc]
    assert "pore.command" in wrong
    (wrong,) = acted(tmp_path, "pore", "python")["wrong"]  # type: ignore[misc]
    assert "save this one first" in wrong
    silent = tmp_path / "silent"
    silent.write_text("#!/bin/sh\nexit 3\n")
    silent.chmod(0o755)
    (wrong,) = acted(tmp_path, str(silent))["wrong"]  # type: ignore[misc]
    assert "status 3" in wrong

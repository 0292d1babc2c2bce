// Starts `pore lsp` and hands it to VS Code: the server tells everything else. And `pore view`, for a preview.
const { spawn } = require("node:child_process");
const { commands, env, Uri, window, workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;
const views = new Map();  // what shows a file, by its path

const pore = () => workspace.getConfiguration("pore").get("command");

// The page of the file that is being edited, in a browser; it follows every save.
function preview() {
  const document = window.activeTextEditor?.document;
  if (document?.languageId !== "pore" || document.isUntitled)
    return window.showErrorMessage("A preview is of a .pore file: save this one first.");
  const path = document.uri.fsPath;
  const known = views.get(path);
  if (known) return known.address && env.openExternal(Uri.parse(known.address));
  const view = { process: spawn(pore(), ["view", path, "--no-browser"]), address: "", said: "" };
  views.set(path, view);
  view.process.stdout.on("data", (text) => {
    if (view.address) return;
    view.said += text;
    view.address = /^http:\S+(?=\s)/m.exec(view.said)?.[0] ?? "";
    if (view.address) env.openExternal(Uri.parse(view.address));
  });
  let wrong = "";
  view.process.stderr.on("data", (text) => { wrong = (wrong + text).slice(-2000); });
  view.process.on("error", (error) => {
    views.delete(path);
    window.showErrorMessage(`\`${pore()}\` cannot be started (${error.message}): say where it is in the setting pore.command.`);
  });
  view.process.on("exit", (code) => {
    views.delete(path);
    if (code) window.showErrorMessage(wrong);
  });
}

exports.activate = (context) => {
  context.subscriptions.push(commands.registerCommand("pore.preview", preview));
  client = new LanguageClient("pore", "Pore", { command: pore(), args: ["lsp"] }, { documentSelector: [{ language: "pore" }] });
  return client.start();
};

exports.deactivate = () => {
  for (const { process } of views.values()) process.kill();
  return client?.stop();
};

// Starts `pore lsp` and hands it to VS Code: the server tells everything else. And `pore view`, for a preview.
const { spawn } = require("node:child_process");
const { homedir } = require("node:os");
const { commands, env, ProgressLocation, Uri, window, workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;
const views = new Map();  // the address of what shows a file, by its path
const running = new Set();

let ending = false;

const pore = () => workspace.getConfiguration("pore").get("command")
  .replace(/^~(?=[\\/])/, homedir())
  .replaceAll("${workspaceFolder}", workspace.workspaceFolders?.[0]?.uri.fsPath ?? "");

// The page of the file that is being edited, in a browser; it follows every save.
function preview() {
  const document = window.activeTextEditor?.document;
  if (document?.languageId !== "pore" || document.isUntitled)
    return window.showErrorMessage("A preview is of a .pore file: save this one first.");
  const path = document.uri.fsPath;
  if (!views.has(path)) views.set(path, begun(path));
  const opened = views.get(path).then((address) => env.openExternal(Uri.parse(address)), (error) => window.showErrorMessage(error.message));
  return window.withProgress({ location: ProgressLocation.Window, title: "Pore: opening the preview" }, () => opened);
}

// Starts `pore view` for a file: its address, when it has one.
function begun(path) {
  const process = spawn(pore(), ["view", path, "--no-browser"]);
  running.add(process);
  let said = "", wrong = "";
  process.stderr.on("data", (text) => { wrong = (wrong + text).slice(-2000); });
  return new Promise((opened, failed) => {
    process.stdout.on("data", (text) => {
      said += text;
      const address = /^http:\S+(?=\s)/m.exec(said)?.[0];
      if (address) opened(address);
    });
    process.on("error", (error) => {
      views.delete(path);
      failed(new Error(`\`${pore()}\` cannot be started (${error.message}): the setting pore.command is to be its path.`));
    });
    process.on("exit", (code) => {
      running.delete(process);
      views.delete(path);
      const why = wrong.trim() || `\`pore view\` has ended with status ${code}, and said nothing.`;
      failed(new Error(why));
      if (code && !ending && /^http:/m.test(said)) window.showErrorMessage(why);  // later than its page was opened
    });
  });
}

exports.activate = (context) => {
  context.subscriptions.push(commands.registerCommand("pore.preview", preview));
  client = new LanguageClient("pore", "Pore", { command: pore(), args: ["lsp"] }, { documentSelector: ["file", "untitled"].map((scheme) => ({ scheme, language: "pore" })) });
  return client.start();
};

exports.deactivate = () => {
  ending = true;
  for (const process of running) process.kill();
  return client?.stop();
};

// Starts `pore lsp` and hands it to VS Code: the server tells everything else.
const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const command = workspace.getConfiguration("pore").get("command");
  const server = { command, args: ["lsp"] };
  client = new LanguageClient("pore", "Pore", server, { documentSelector: [{ language: "pore" }] });
  return client.start();
};

exports.deactivate = () => client?.stop();

// The client: starts `conserva lsp` for files that end with `.rhai`.
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

function start() {
    const settings = vscode.workspace.getConfiguration("conserva");
    const server = { command: settings.get("program"), args: ["lsp", ...settings.get("arguments")] };
    client = new LanguageClient("conserva", "Conserva", server, { documentSelector: [{ language: "conserva" }] });
    return client.start();
}

async function restart() {
    await client?.stop();
    await start();
}

/** Runs the script of the active editor in a terminal. */
async function run() {
    const document = vscode.window.activeTextEditor?.document;
    if (!document || document.isUntitled) {
        return;
    }
    await document.save();
    const program = vscode.workspace.getConfiguration("conserva").get("program");
    const terminal = vscode.window.terminals.find((one) => one.name === "Conserva") ?? vscode.window.createTerminal("Conserva");
    terminal.show(true);
    terminal.sendText(`${program} run "${document.fileName}"`);
}

exports.activate = async (context) => {
    context.subscriptions.push(vscode.commands.registerCommand("conserva.restart", restart));
    context.subscriptions.push(vscode.commands.registerCommand("conserva.run", run));
    context.subscriptions.push(vscode.workspace.onDidChangeConfiguration((change) => change.affectsConfiguration("conserva") && restart()));
    await start();
};

exports.deactivate = () => client?.stop();

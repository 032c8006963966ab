// The colors of a script: `node --test`. The grammar is read as VS Code does it.
const assert = require("node:assert");
const fs = require("node:fs");
const path = require("node:path");
const test = require("node:test");
const oniguruma = require("vscode-oniguruma");
const textmate = require("vscode-textmate");

const scopes = async (lines) => {
    const wasm = fs.readFileSync(require.resolve("vscode-oniguruma/release/onig.wasm")).buffer;
    await oniguruma.loadWASM(wasm);
    const registry = new textmate.Registry({
        onigLib: Promise.resolve({
            createOnigScanner: (sources) => new oniguruma.OnigScanner(sources),
            createOnigString: (text) => new oniguruma.OnigString(text),
        }),
        loadGrammar: async () => {
            const file = path.join(__dirname, "syntaxes/conserva.tmLanguage.json");
            return textmate.parseRawGrammar(fs.readFileSync(file, "utf8"), file);
        },
    });
    const grammar = await registry.loadGrammar("source.conserva");
    let state = textmate.INITIAL;
    const found = [];
    for (const line of lines) {
        const { tokens, ruleStack } = grammar.tokenizeLine(line, state);
        state = ruleStack;
        for (const token of tokens) {
            found.push([line.slice(token.startIndex, token.endIndex), token.scopes.at(-1).replace(".conserva", "")]);
        }
    }
    return (text) => found.filter(([word]) => word.trim() === text).map(([, scope]) => scope);
};

test("words, functions, numbers and strings have their colors", async () => {
    const of = await scopes([
        "// a ring /* no comment",
        "let plate = ring(#{ inner_radius: 1.5e-3, if: 2 });",
        "/* one /* two */ let */",
        'plate.refine(2); print("a \\n rings" + `x ${sin(plate.nodes) + 1} y`);',
        "fn twice(x) { true }",
        "let other = twice(PI);",
    ]);
    assert.deepStrictEqual(of("ring"), ["support.function"]);
    assert.deepStrictEqual(of("let"), ["keyword.control", "comment.block", "keyword.control"]);
    assert.deepStrictEqual(of("inner_radius"), ["variable.other.property"]);
    assert.deepStrictEqual(of("1.5e-3"), ["constant.numeric"]);
    assert.deepStrictEqual(of("refine"), ["support.function.member"]);
    assert.deepStrictEqual(of("sin"), ["support.function"]);
    assert.deepStrictEqual(of("\\n"), ["constant.character.escape"]);
    assert.deepStrictEqual(of("twice"), ["entity.name.function", "entity.name.function.call"]);
    assert.deepStrictEqual(of("true"), ["constant.language"]);
    assert.deepStrictEqual(of("PI"), ["constant.language"]);
    assert.deepStrictEqual(of("if"), ["variable.other.property"]);
});

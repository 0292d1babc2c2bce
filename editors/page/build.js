// Bundles src/editor.js for the page, and gathers the notices of what is in the bundle. The digest in its first line tells
// a test, which has no npm, whether the bundle is that of these sources.
import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const WEB = "../../porelang/preview/web/";
const sources = ["build.js", "package-lock.json", ...readdirSync("src").sort().map((name) => `src/${name}`)];
const digest = createHash("sha256");
for (const name of sources) digest.update(readFileSync(name));

const { metafile, outputFiles } = await build({
  entryPoints: ["src/editor.js"], bundle: true, format: "esm", minify: true, target: "es2022", legalComments: "none",
  metafile: true, write: false, outfile: "editor.js",
  banner: { js: `// Made by \`make page\` from editors/page, ${digest.digest("hex")}. Notices: LICENCES.txt` },
});

const packages = new Set();
for (const [path, { bytesInOutput }] of Object.entries(Object.values(metafile.outputs)[0].inputs)) {
  const found = /.*node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(path);
  if (found && bytesInOutput) packages.add(found[1]);
}
let notices = "editor.js holds these packages. Each stands under the notice below it.\n";
for (const name of [...packages].sort()) {
  const { version, license } = JSON.parse(readFileSync(`node_modules/${name}/package.json`));
  if (license !== "MIT") throw new Error(`${name} is not MIT: ${license}`);
  const notice = readFileSync(`node_modules/${name}/LICENSE`, "utf8").trim();
  notices += `\n${"-".repeat(80)}\n${name} ${version}\n\n${notice}\n`;
}
writeFileSync(`${WEB}LICENCES.txt`, notices);
writeFileSync(`${WEB}editor.js`, outputFiles[0].contents);
console.log(`editor.js: ${Math.round(outputFiles[0].contents.length / 1024)} KiB, ${packages.size} packages`);

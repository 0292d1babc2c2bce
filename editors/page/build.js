// Bundles src/editor.js for the page of `pore view` and widget/widget.js for notebooks, and gathers the notices of what is in
// them. The digest in the first line of each tells a test, which has no npm, whether it is that of these sources.
import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const WEB = "../../porelang/preview/web/";
const inside = (folder) => readdirSync(folder).sort().map((name) => `${folder}/${name}`);
const common = ["build.js", "package-lock.json"];
const viewer = ["camera.js", "controls.js", "hands.js", "painter.js", "section.js", "viewer.js", "wire.js", "page.css", "page.html"].map((name) => WEB + name);

async function bundle(entry, outfile, sources, notices) {
  const digest = createHash("sha256");
  for (const name of sources) digest.update(readFileSync(name));
  const { metafile, outputFiles } = await build({
    entryPoints: [entry], bundle: true, format: "esm", minify: true, target: "es2022", legalComments: "none", metafile: true, write: false,
    outfile: "out.js", loader: { ".css": "text", ".html": "text" },
    banner: { js: `// Made by \`make page\` from editors/page, ${digest.digest("hex")}. ${notices}` },
  });
  writeFileSync(outfile, outputFiles[0].contents);
  console.log(`${outfile}: ${Math.round(outputFiles[0].contents.length / 1024)} KiB`);
  return Object.entries(Object.values(metafile.outputs)[0].inputs);
}

const packages = new Set();
const inputs = await bundle("src/editor.js", `${WEB}editor.js`, [...common, ...inside("src")], "Notices: LICENCES.txt");
for (const [path, { bytesInOutput }] of inputs) {
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

const ours = await bundle("widget/widget.js", "../../porelang/notebook/widget.js", [...common, ...inside("widget"), ...viewer], "All of it is porelang's.");
const strays = ours.map(([path]) => path).filter((path) => ![...viewer, ...inside("widget")].includes(path));
if (strays.length) throw new Error(`the digest of widget.js leaves out ${strays.join(", ")}`);

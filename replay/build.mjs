// Bundles the program of the replay page into the Python package, with its style and the licence of what is in it.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { copyFileSync, readdirSync, readFileSync, writeFileSync } from "node:fs";

const room = "../stackdsl/viewing/replay/";
// What it is made from, so that a test can tell whether it is what these sources make.
const hash = createHash("sha256");
for (const file of ["package-lock.json", ...readdirSync("src").sort().map((name) => `src/${name}`)]) {
  hash.update(readFileSync(file));
}
await build({
  entryPoints: ["src/main.ts"],
  outfile: `${room}replay.js`,
  bundle: true,
  minify: true,
  charset: "ascii",
  format: "iife",
  target: "es2022",
  footer: { js: `// made from ${hash.digest("hex")}` },
  legalComments: "none", // the page has the licence as a whole
});
copyFileSync("src/replay.css", `${room}replay.css`);
const { version } = JSON.parse(readFileSync("node_modules/three/package.json", "utf8"));
const licence = readFileSync("node_modules/three/LICENSE", "utf8").trim();
writeFileSync(`${room}replay.LICENSE.txt`, `This page contains three.js ${version}, under this licence:\n\n${licence}\n`);

// Bundles the viewer into src/mobius_match/viewer/viewer.js, and lays axe-core beside the tests, which run without
// Node. Run by `make viewer`.
import { createHash } from "node:crypto";
import { copyFileSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = join(here, "../src/mobius_match/viewer/viewer.js");

// The same digests as in tests/viewer/test_bundle.py: of the sources, by name, and of all below the first line.
const sources = readdirSync(here).filter((name) => /\.(m?js|json|css|html)$/.test(name)).sort();
const digest = createHash("sha256");
for (const name of sources) digest.update(name + "\0").update(readFileSync(join(here, name))).update("\0");

const bundle = await build({
  entryPoints: [join(here, "main.js")],
  bundle: true,
  minify: true,
  write: false,
  format: "iife",
  target: "es2020",
  charset: "ascii",
  legalComments: "none",
  loader: { ".css": "text", ".html": "text" },
});
const licence = readFileSync(join(here, "node_modules/three/LICENSE"), "utf-8").replace(/[^\x00-\x7f]/g, "(c)");
// A page holds the script in itself, where "</script" would end it.
const script = bundle.outputFiles[0].text.replace(/<\/(script)/gi, "<\\/$1").replace(/<!--/g, "<\\!--");
const body = `/* Contains three.js.\n\n${licence.trim()}\n*/\n${script}`;
const built = createHash("sha256").update(body).digest("hex");
writeFileSync(out, `/* mobius-match viewer; sources ${digest.digest("hex")}; built ${built} */\n${body}`);

const axe = join(here, "../tests/viewer/axe");
mkdirSync(axe, { recursive: true });
for (const name of ["axe.min.js", "LICENSE"]) copyFileSync(join(here, "node_modules/axe-core", name), join(axe, name));

// Build the page: node build.mjs CORE.wasm ROBOTS/ OUTPUT/ writes studio.html and made.json. Same sources, same bytes.
import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build, transform } from "esbuild";
import { gzipSync } from "fflate";

const [corePath, robotsPath, outputPath] = process.argv.slice(2);
const here = fileURLToPath(new URL(".", import.meta.url));
const FIRST = "hypertuna"; // of the robots in the list

const packed = (bytes) => gzipSync(bytes, { level: 9, mtime: 0 });
const base64 = (bytes) => Buffer.from(bytes).toString("base64");
const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

async function bundled(entry, define = {}) {
  const { outputFiles } = await build({
    absWorkingDir: here,
    entryPoints: [entry],
    bundle: true,
    minify: true,
    write: false,
    format: "iife",
    target: "es2022",
    charset: "utf8",
    legalComments: "none",
    define,
  });
  return outputFiles[0].text.trim().replaceAll("</script", "<\\/script");
}

function robots() {
  const names = readdirSync(robotsPath)
    .map((file) => basename(file, ".robot"))
    .sort((a, b) => (b === FIRST) - (a === FIRST) || (a < b ? -1 : 1));
  return names.map((name) => ({ name, image: readFileSync(join(robotsPath, `${name}.robot`)) }));
}

/** The style sheets: studio.css, then those of views. */
function styles() {
  const sheets = readdirSync(here).filter((file) => file.endsWith(".css"));
  const order = ["studio.css", ...sheets.filter((file) => file !== "studio.css").sort()];
  return order.map((file) => readFileSync(join(here, file), "utf8")).join("\n");
}

async function page(core, list) {
  const worker = await bundled("worker.ts");
  const css = await transform(styles(), { loader: "css", minify: true });
  const parts = {
    styles: css.code.trim(),
    robots: JSON.stringify({
      robots: list.map(({ name, image }) => ({ name, image: base64(packed(image)) })),
      start: {},
    }).replaceAll("<", "\\u003c"),
    core: base64(packed(core)),
    theme: await bundled("theme.ts"),
    script: await bundled("page.ts", { WORKER: JSON.stringify(worker) }),
  };
  const template = readFileSync(join(here, "studio.html"), "utf8");
  return template.replace(/\/\*\{(\w+)\}\*\//g, (_, name) => parts[name]);
}

function made(core, list, html) {
  const lock = JSON.parse(readFileSync(join(here, "package-lock.json"), "utf8")).packages;
  const sources = readdirSync(here).filter((file) => /\.(ts|mjs|css|html|json)$/.test(file));
  return {
    tools: Object.fromEntries(["esbuild", "fflate"].map((name) => [name, lock[`node_modules/${name}`].version])),
    sources: {
      core: sha256(core),
      robots: Object.fromEntries(list.map(({ name, image }) => [name, sha256(image)])),
      page: Object.fromEntries(sources.sort().map((file) => [file, sha256(readFileSync(join(here, file)))])),
    },
    sizes: { "core.wasm": core.length, "studio.html": html.length, "studio.html.gz": packed(html).length },
  };
}

const core = readFileSync(corePath);
const list = robots();
const html = Buffer.from(await page(core, list));
writeFileSync(join(outputPath, "studio.html"), html);
writeFileSync(join(outputPath, "made.json"), `${JSON.stringify(made(core, list, html), null, 2)}\n`);

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
const UPLOT = "node_modules/uplot/dist/uPlot.min.css"; // the layout of its plots
const SEA = /(?<=id="sea-block">)[^<]*/; // what is unpacked when the Sea view is opened
const TOOLS = ["esbuild", "fflate", "three", "@mcap/core", "@foxglove/crc", "fzstd", "uplot"]; // whose versions make the bytes

const packed = (bytes) => gzipSync(bytes, { level: 9, mtime: 0 });
const base64 = (bytes) => Buffer.from(bytes).toString("base64");
const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

/** A queue that only the indexed reader of @mcap/core needs, which is not in the page. */
const unused = {
  name: "unused",
  setup(build) {
    build.onResolve({ filter: /^heap-js$/ }, () => ({ path: "heap-js", namespace: "unused", sideEffects: false }));
    build.onLoad({ filter: /.*/, namespace: "unused" }, () => ({ contents: "export const Heap = null;" }));
  },
};

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
    plugins: [unused],
  });
  return outputFiles[0].text.trim().replaceAll("</script", "<\\/script");
}

function robots() {
  const names = readdirSync(robotsPath)
    .map((file) => basename(file, ".robot"))
    .sort((a, b) => (b === FIRST) - (a === FIRST) || (a < b ? -1 : 1));
  return names.map((name) => ({ name, image: readFileSync(join(robotsPath, `${name}.robot`)) }));
}

/** The style sheets: of uPlot, studio.css, then those of views. */
function styles() {
  const sheets = readdirSync(here).filter((file) => file.endsWith(".css"));
  const order = [UPLOT, "studio.css", ...sheets.filter((file) => file !== "studio.css").sort()];
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
    sea: base64(packed(Buffer.from(await seaBlock()))),
    theme: await bundled("theme.ts"),
    script: await bundled("page.ts", { WORKER: JSON.stringify(worker) }),
  };
  const template = readFileSync(join(here, "studio.html"), "utf8");
  return template.replace(/\/\*\{(\w+)\}\*\//g, (_, name) => parts[name]);
}

/** The Sea view with what it stands on, unpacked when it is first opened. */
async function seaBlock() {
  return bundled("sea/main.ts", { LOG_WORKER: JSON.stringify(await bundled("sea/reader.ts")) });
}

function made(core, list, html) {
  const lock = JSON.parse(readFileSync(join(here, "package-lock.json"), "utf8")).packages;
  const folders = ["", "sea/"];
  const sources = folders
    .flatMap((folder) => readdirSync(join(here, folder)).map((file) => folder + file))
    .filter((file) => /\.(ts|mjs|css|html|json)$/.test(file));
  return {
    tools: Object.fromEntries(TOOLS.map((name) => [name, lock[`node_modules/${name}`].version])),
    sources: {
      core: sha256(core),
      robots: Object.fromEntries(list.map(({ name, image }) => [name, sha256(image)])),
      page: Object.fromEntries(sources.sort().map((file) => [file, sha256(readFileSync(join(here, file)))])),
    },
    sizes: {
      "core.wasm": core.length,
      "studio.html": html.length,
      "studio.html.gz": packed(html).length,
      "without the Sea view": packed(Buffer.from(html.toString().replace(SEA, ""))).length,
    },
  };
}

const core = readFileSync(corePath);
const list = robots();
const html = Buffer.from(await page(core, list));
writeFileSync(join(outputPath, "studio.html"), html);
writeFileSync(join(outputPath, "made.json"), `${JSON.stringify(made(core, list, html), null, 2)}\n`);

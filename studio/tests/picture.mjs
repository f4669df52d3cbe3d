// Draw docs/studio.png, the picture of the page in the docs: node studio/tests/picture.mjs
import { fileURLToPath } from "node:url";
import { browser, open } from "./browser.mjs";

const chrome = await browser();
const { page } = await open(chrome, { viewport: { width: 1200, height: 760 }, hash: "#robot=hypertuna" });
await page.screenshot({ path: fileURLToPath(new URL("../../docs/studio.png", import.meta.url)) });
await chrome.close();

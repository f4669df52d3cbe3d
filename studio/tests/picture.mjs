// Draw docs/studio.png, the picture of the page in the docs: node studio/tests/picture.mjs
import { fileURLToPath } from "node:url";
import { chrome, open } from "./browser.mjs";

const { page } = await open({ viewport: { width: 1200, height: 760 }, hash: "#robot=hypertuna" });
await page.screenshot({ path: fileURLToPath(new URL("../../docs/studio.png", import.meta.url)) });
await chrome.close();

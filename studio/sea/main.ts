// The block of the page that is unpacked when the Sea view is first opened.
import { SeaRoom } from "./view.ts";

Object.assign(globalThis, { SeaRoom });

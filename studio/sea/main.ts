// The script that the page unpacks when the Sea view is first opened.
import { SeaRoom } from "./view.ts";

Object.assign(globalThis, { SeaRoom });

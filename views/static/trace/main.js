// The page of a trace that is all there.

import { App, known, readContent } from "./page.js";

known(new App(readContent()));

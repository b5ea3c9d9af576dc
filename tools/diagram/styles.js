// Print the styles of diagram-js without those of features that are not bundled, such as its palette and its menus: rules
// with classes that the bundled script never gives, and variables that only those rules use.
import { readFileSync } from "node:fs";

const TYPES = ["shape", "connection", "label", "root"]; // the script puts "djs-" before them
const PREFIXES = ["djs-cursor-"]; // the script puts them before names of its callers

const script = readFileSync(process.argv[2], "utf8");
const words = new Set([...script.matchAll(/[\w-]+/g)].map(([word]) => word));
for (const type of TYPES) {
  words.add(`djs-${type}`);
}

/** @param {string} name */
function isGiven(name) {
  return words.has(name) || PREFIXES.some((prefix) => name.startsWith(prefix));
}

/** @param {string} rule */
function applicable(rule) {
  const [selectors, body] = rule.split("{");
  const kept = selectors
    .split(",")
    .map((selector) => selector.trim())
    .filter((selector) => [...selector.matchAll(/\.([\w-]+)/g)].every(([, name]) => isGiven(name)));
  return kept.length > 0 ? `${kept.join(",\n")} {${body}` : "";
}

/** @param {string} styles */
function withoutUnusedVariables(styles) {
  const used = new Set([...styles.matchAll(/var\(\s*(--[\w-]+)/g)].map(([, name]) => name));
  return styles.replace(/^ *(--[\w-]+):[^;]*;\n/gm, (line, name) => (used.has(name) ? line : ""));
}

const source = readFileSync("node_modules/diagram-js/assets/diagram-js.css", "utf8");
const rules = source.replace(/\/\*[\s\S]*?\*\//g, "").match(/[^{}]+\{[^}]*\}/g);
let styles = rules.map(applicable).filter(Boolean).join("\n\n");
for (let last = ""; last !== styles; ) {
  last = styles;
  styles = withoutUnusedVariables(styles);
}
console.log(styles.replace(/\n(\s*\n)+/g, "\n\n"));

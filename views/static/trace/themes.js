// Colours.

/** @import { Theme, ThemeName } from "./types.js" */

/**
 * Of node nets (after Paul Tol's schemes, distinguishable with all kinds of colour vision), and of the rest.
 *
 * @type {Record<ThemeName, Theme>}
 */
export const THEMES = {
  light: {
    back: "#ffffff",
    panel: "#f5f7f9",
    ink: "#17212b",
    soft: "#5b6773",
    line: "#d5dbe1",
    grid: "#eef1f4",
    topic: "#1f6fb2",
    topicFill: "#bcd9f0",
    service: "#1c7c54",
    serviceFill: "#8fcfb1",
    signal: "#a86a00",
    signalFill: "#f6d58d",
    handler: "#7a3fa0",
    alarm: "#c62828",
    cursor: "#c2185b",
    loop: "#f3e9fb",
    loopInk: "#6a3a96",
    fold: "#e3e8ed",
    cause: "#a04000",
    nodes: ["#4477aa", "#cc6677", "#228833", "#b8860b", "#8855aa", "#2a9db0", "#996633", "#667788"],
  },
  dark: {
    back: "#12181f",
    panel: "#1a222b",
    ink: "#e6ebf0",
    soft: "#9aa7b4",
    line: "#33404d",
    grid: "#1c252e",
    topic: "#6db3ef",
    topicFill: "#234a6b",
    service: "#5ecb9b",
    serviceFill: "#1f5a41",
    signal: "#f0b64a",
    signalFill: "#5d4413",
    handler: "#c99bea",
    alarm: "#ff6b6b",
    cursor: "#ff6fa8",
    loop: "#2a2140",
    loopInk: "#c9a6f0",
    fold: "#26313c",
    cause: "#ffa05c",
    nodes: ["#7aaadd", "#e58a99", "#57b565", "#d9b040", "#b78ad6", "#5cc5d6", "#c69a66", "#9aabbc"],
  },
};

// Numbers of things, in words.

/** Such as "1 error" and "2 errors". @type {(number: number, noun: string) => string} */
export const counted = (number, noun) => `${number} ${noun}${number === 1 ? "" : "s"}`;

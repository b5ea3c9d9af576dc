// Maps that hold what is looked for.

/**
 * The value of a key that a map has.
 *
 * @template K, V
 * @param {Map<K, V>} map
 * @param {K} key
 * @returns {V}
 */
export function lookUp(map, key) {
  const found = map.get(key);
  if (found === undefined) throw new Error(`nothing has the key ${key}`);
  return found;
}

/**
 * The value of a key; what a map has none of, it gets.
 *
 * @template K, V
 * @param {Map<K, V>} map
 * @param {K} key
 * @param {() => V} make
 * @returns {V}
 */
export function lookUpOrAdd(map, key, make) {
  const found = map.get(key) ?? make();
  map.set(key, found);
  return found;
}

// What both kinds of pages have in common.

/** What is called when something happens to an element, by the attribute that names it: `onclick`, `oninput`. */
type Handlers = {
  [K in keyof GlobalEventHandlersEventMap as `on${K}`]?: (event: GlobalEventHandlersEventMap[K]) => unknown;
};

export interface Attributes extends Handlers {
  [name: string]: string | number | boolean | null | undefined | ((event: never) => unknown);
}

export type Child = Element | string | null | undefined | false;

// Moving about in an <svg>: drag, wheel, pinch and keys.
//
// const pan = NetPan.attach(svg)   svg has a viewBox of all it holds
// pan.fit()                        shows everything; call it after drawing anew
// pan.show(x, y, width, height)    brings a part into view, enlarged as far as it stays readable
"use strict";

var NetPan = (function () {
  const MOST = 6;

  function attach(svg) {
    let view = null;
    const whole = () => {
      const [x, y, width, height] = svg.dataset.whole.split(" ").map(Number);
      return { x, y, width, height };
    };
    const apply = () => svg.setAttribute("viewBox", [view.x, view.y, view.width, view.height].join(" "));
    const size = () => ({ width: svg.clientWidth || 800, height: svg.clientHeight || 600 });
    const scale = () => Math.min(size().width / view.width, size().height / view.height);

    // A part of the plane with the form of the window.
    function framed(part) {
      const { width, height } = size();
      const by = Math.min(width / part.width, height / part.height);
      const wide = width / by, high = height / by;
      return { x: part.x - (wide - part.width) / 2, y: part.y - (high - part.height) / 2, width: wide, height: high };
    }

    function fit() {
      svg.dataset.whole = svg.dataset.whole || svg.getAttribute("viewBox");
      const part = whole();
      view = framed({ x: part.x - 8, y: part.y - 8, width: part.width + 16, height: part.height + 16 });
      apply();
    }

    function redrawn() {
      svg.dataset.whole = svg.getAttribute("viewBox");
      fit();
    }

    function zoom(factor, atX, atY) {
      const box = svg.getBoundingClientRect();
      const along = atX === undefined ? 0.5 : (atX - box.left) / box.width;
      const down = atY === undefined ? 0.5 : (atY - box.top) / box.height;
      const all = framed(whole());
      const width = Math.min(Math.max(view.width / factor, size().width / MOST), all.width * 2);
      const by = width / view.width;
      view = { x: view.x + view.width * (1 - by) * along, y: view.y + view.height * (1 - by) * down, width, height: view.height * by };
      apply();
    }

    function move(dx, dy) {
      view.x += dx * view.width;
      view.y += dy * view.height;
      apply();
    }

    function show(x, y, width, height) {
      const wanted = Math.max(scale(), Math.min(1.2, size().width / (width * 1.5), size().height / (height * 1.5)));
      const wide = Math.max(size().width / wanted, width * 1.1), high = Math.max(size().height / wanted, height * 1.1);
      view = framed({ x: x + width / 2 - wide / 2, y: y + height / 2 - high / 2, width: wide, height: high });
      apply();
    }

    const pointers = new Map();
    let moved = 0;
    svg.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      if (!pointers.size) moved = 0;
      pointers.set(event.pointerId, event);
    });
    svg.addEventListener("pointermove", (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      const others = [...pointers.values()].filter((one) => one.pointerId !== event.pointerId);
      moved += Math.hypot(event.clientX - last.clientX, event.clientY - last.clientY);
      if (moved > 4 && !svg.hasPointerCapture(event.pointerId)) svg.setPointerCapture(event.pointerId);
      if (others.length) {
        const apart = (one) => Math.hypot(one.clientX - others[0].clientX, one.clientY - others[0].clientY) || 1;
        zoom(apart(event) / apart(last), (event.clientX + others[0].clientX) / 2, (event.clientY + others[0].clientY) / 2);
      } else {
        move(-(event.clientX - last.clientX) / size().width, -(event.clientY - last.clientY) / size().height);
      }
      pointers.set(event.pointerId, event);
    });
    for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, (event) => pointers.delete(event.pointerId));
    // What ends a drag is no click.
    svg.addEventListener("click", (event) => { if (moved > 4) { event.stopImmediatePropagation(); moved = 0; } }, true);
    svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), event.clientX, event.clientY);
    }, { passive: false });
    new ResizeObserver(() => {
      if (!view) return;
      view = framed(view);
      apply();
    }).observe(svg);
    redrawn();
    return { fit, redrawn, zoom, move, show };
  }

  return { attach };
})();

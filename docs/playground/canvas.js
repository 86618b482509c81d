// What map and plots have in common: a canvas as sharp as the screen, and the page's colours.
"use strict";

(() => {
  const { getPropertyValue } = CSSStyleDeclaration.prototype;

  /** The value of a colour of style.css, in the present scheme. */
  const colour = (name) => getPropertyValue.call(getComputedStyle(document.documentElement), `--${name}`).trim();

  /** A cleared canvas to draw on in CSS pixels: its context, width and height. */
  function clear(canvas) {
    const { clientWidth: width, clientHeight: height } = canvas;
    const scale = globalThis.devicePixelRatio || 1;
    const [across, down] = [Math.round(width * scale), Math.round(height * scale)];
    if (canvas.width !== across || canvas.height !== down) {
      canvas.width = across;
      canvas.height = down;
    }
    const context = canvas.getContext("2d");
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, width, height);
    context.lineJoin = "round";
    context.font = '12px system-ui, "DejaVu Sans", sans-serif';
    return { context, width, height };
  }

  /** A number of 1, 2 or 5 times a power of ten that is not below `least`. */
  function round125(least) {
    const power = 10 ** Math.floor(Math.log10(least));
    return power * ([1, 2, 5].find((factor) => factor * power >= least * (1 - 1e-9)) ?? 10);
  }

  Object.assign(popsteer, { clear, colour, round125 });
})();

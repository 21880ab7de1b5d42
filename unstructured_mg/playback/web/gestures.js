// Mouse, touch and wheel on the picture: turn, move, come closer.
"use strict";
(function (umg) {
  // Radians a picture's height of dragging; factor a wheel's notch.
  const TURN = 4, NOTCH = 1.1;

  umg.gestures = function (canvas, camera) {
    const pointers = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture(event.pointerId);
    });
    for (const name of ["pointerup", "pointercancel"])
      canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      const last = pointers.get(event.pointerId);
      if (last === undefined) return;
      const here = [event.clientX, event.clientY], height = canvas.clientHeight;
      const right = (here[0] - last[0]) / height, down = (here[1] - last[1]) / height;
      if (pointers.size === 2) {
        const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
        const apart = (at) => Math.max(Math.hypot(at[0] - other[0], at[1] - other[1]), 1);
        camera.dolly(apart(last) / apart(here));
        camera.pan(right / 2, -down / 2);
      } else if (event.shiftKey || event.buttons === 4 || event.buttons === 2) camera.pan(right, -down);
      else camera.orbit(TURN * right, TURN * down);
      pointers.set(event.pointerId, here);
    });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      camera.dolly(NOTCH ** Math.max(Math.min(event.deltaY / 100, 3), -3));
    }, { passive: false });
  };
})((globalThis.umg = globalThis.umg || {}));

// Rigid motions of the floor plane: {yaw, x, y}, radians and metres, z up.
"use strict";
(function (umg) {
  const STILL = { yaw: 0, x: 0, y: 0 };
  const TURN = 2 * Math.PI;

  // The motion that does `first`, then `second`; its yaw within half a turn.
  function after(second, first) {
    const c = Math.cos(second.yaw), s = Math.sin(second.yaw), yaw = second.yaw + first.yaw;
    return {
      yaw: yaw - TURN * Math.round(yaw / TURN),
      x: second.x + c * first.x - s * first.y,
      y: second.y + s * first.x + c * first.y,
    };
  }

  function apply(motion, [x, y, z]) {
    const c = Math.cos(motion.yaw), s = Math.sin(motion.yaw);
    return [c * x - s * y + motion.x, s * x + c * y + motion.y, z];
  }

  umg.motion = { STILL, after, apply };
})((globalThis.umg = globalThis.umg || {}));

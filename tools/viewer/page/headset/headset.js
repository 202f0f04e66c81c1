// SPDX-License-Identifier: GPL-3.0-or-later
// Shows the model in a headset (WebXR): a picture for each eye, and movements by the sticks of the controllers.
import {scaledCamera, worldFromCam} from '../camera.js';
import {PICTURE_BYTES} from '../drawing/renderer.js';
import {stickMove} from '../gamepad.js';
import {FramePace} from './frame_pace.js';
import {HeadsetPlace, metresOfUnit} from './headset_place.js';
/** @import {Viewer} from '../viewer.js' */
/** @import {LengthUnit, Vector} from '../types.d.ts' */

const FLY_SPEED = 0.6;           // typical depths a second
const TURN_STEP = Math.PI / 6;   // of a stick that is pushed aside; turning evenly makes people sick
const PUSHED = 0.7;              // of a stick's way, from which it is pushed aside
const RELEASED = 0.3;            // of it, up to which it is let go
const LONGEST_FLIGHT_S = 0.1;      // limits a step after a slow picture
const USUAL_RATE = 72;           // frames a second, of a headset that does not say its own
// One that moves with the head disturbs.
const BACKGROUND = {above: [0.25, 0.27, 0.3], below: [0.25, 0.27, 0.3], continues: false};
const MODE = 'immersive-vr';

// Returns whether this device has a headset that pages may use.
export async function hasHeadset() {
  try {
    return await navigator.xr?.isSessionSupported(MODE) ?? false;
  } catch {
    return false;  // a page around this one does not allow it
  }
}

// What a headset is drawn with while it shows the model.
/** @typedef {{session: XRSession, layer: XRWebGLLayer, space: XRReferenceSpace, pace: FramePace}} Shown */

export class Headset {
  // `unit` says how long a scene unit is.
  /** @param {Viewer} viewer @param {() => LengthUnit} unit */
  constructor(viewer, unit) {
    this.viewer = viewer;
    this.unit = unit;
    /** @type {XRSession | null} */
    this.session = null;
    this.changed = () => {};  // after it has begun or ended
    this.drawn = () => {};    // after the pictures of each frame
    this.starts = false;
    this.isPushed = false;    // the stick that turns
    viewer.canvas.addEventListener('webglcontextlost', () => this.end());
  }

  // Must be called while the browser handles a click. Throws where the browser or the visitor refuses.
  async begin() {
    const {viewer} = this;
    const {gl} = viewer;
    if (this.session || this.starts || !navigator.xr) return;
    this.starts = true;
    try {
      const session = await navigator.xr.requestSession(MODE);
      try {
        await gl.makeXRCompatible();
        // The model's own depth is all that is drawn, and it is not the headset's business.
        const layer = new XRWebGLLayer(session, gl, {antialias: false, depth: false, stencil: false, alpha: false});
        const space = await session.requestReferenceSpace('local');
        session.updateRenderState({baseLayer: layer});
        this.show({session, layer, space, pace: this.paceOf(session)});
      } catch (error) {
        await session.end();
        throw error;
      }
    } finally {
      this.starts = false;
    }
  }

  end() {
    this.session?.end().catch(() => {});  // it has ended by itself
  }

  /** @param {XRSession} session */
  paceOf(session) {
    const shares = {auto: null, sharp: 1, fast: 0.5};
    return new FramePace(session.frameRate ?? USUAL_RATE, shares[this.viewer.sizes.quality]);
  }

  /** @param {Shown} shown */
  show(shown) {
    const {viewer} = this;
    const {navigation} = viewer;
    const {session} = shown;
    this.session = session;
    viewer.rest();
    navigation.jump = null;
    const place = new HeadsetPlace(metresOfUnit(this.unit(), navigation.typicalDepth), navigation.up);
    let isLaid = false;
    let last = 0;
    /** @type {XRFrameRequestCallback} */
    const frame = (now, xrFrame) => {
      if (this.session !== session) return;
      session.requestAnimationFrame(frame);
      const head = xrFrame.getViewerPose(shown.space);
      if (!head || viewer.gl.isContextLost() || !viewer.hasMesh) return;
      if (last > 0) shown.pace.note(now - last);
      if (!isLaid) place.layAt(head.transform, navigation.pose);
      isLaid = true;
      this.follow(place, head.transform, last > 0 ? Math.min((now - last) / 1000, LONGEST_FLIGHT_S) : 0);
      last = now;
      this.draw(shown, place, head.views);
    };
    session.addEventListener('end', () => {
      this.session = null;
      viewer.goOn();
      this.changed();
    });
    session.requestAnimationFrame(frame);
    this.changed();
  }

  // Draws the picture of each eye, of at most as many pixels as the page's own pictures take memory.
  /** @param {Shown} shown @param {HeadsetPlace} place @param {readonly XRView[]} views */
  draw({layer, pace}, place, views) {
    const {viewer} = this;
    const {renderer, sizes} = viewer;
    const most = renderer.bytesToDraw(sizes.moving(), sizes.whole()) / PICTURE_BYTES;
    for (const view of views) {
      const viewport = layer.getViewport(view);
      if (!viewport || viewport.width * viewport.height === 0) continue;
      const {width, height} = viewport;
      const share = Math.min(pace.share, Math.sqrt(most / (width * height)));
      const target = viewer.drawTarget(scaledCamera(place.cameraOf(view, width, height), share));
      renderer.presentIn(layer.framebuffer, viewport, target, BACKGROUND);
    }
    this.drawn();
  }

  // Moves by the sticks, and takes the head's pose as the visitor's.
  /** @param {HeadsetPlace} place @param {XRRigidTransform} head @param {number} seconds */
  follow(place, head, seconds) {
    const {navigation} = this.viewer;
    const {move, turn} = this.sticks();
    if (Math.abs(turn) < RELEASED) this.isPushed = false;
    if (Math.abs(turn) > PUSHED && !this.isPushed) {
      this.isPushed = true;
      place.turn(head, Math.sign(turn) * TURN_STEP);
    }
    navigation.pose = place.poseOf(head);
    if (move.some((part) => part !== 0)) this.fly(place, move, seconds);
    navigation.pose = place.poseOf(head);
  }

  // Flies in the directions of the head, slowly where it leads away from what was photographed.
  /** @param {HeadsetPlace} place @param {Vector} move @param {number} seconds */
  fly(place, [right, down, forward], seconds) {
    const {navigation} = this.viewer;
    const {pose, hold, typicalDepth} = navigation;
    const far = FLY_SPEED * typicalDepth * seconds;
    const ahead = worldFromCam(pose.rotation, [right * far, 0, forward * far]);
    const wanted = pose.position.map((value, axis) => value + ahead[axis] - navigation.up[axis] * down * far);
    const position = navigation.guarded(wanted);
    hold.noteMove();
    const part = hold.allowed(pose, {...pose, position});
    place.move(position.map((value, axis) => part * (value - pose.position[axis])));
  }

  // Returns how the sticks are held: the left one flies, the right one turns, lowers and raises.
  sticks() {
    /** @type {Vector} */
    const move = [0, 0, 0];
    let turn = 0;
    for (const {handedness, gamepad} of this.session?.inputSources ?? []) {
      if (gamepad?.mapping !== 'xr-standard') continue;
      const [across, along] = [gamepad.axes[2] ?? 0, gamepad.axes[3] ?? 0];
      if (handedness === 'right') {
        turn = across;
        move[1] += stickMove(along);
      } else {
        move[0] += stickMove(across);
        move[2] -= stickMove(along);
      }
    }
    return {move, turn};
  }
}

// SPDX-License-Identifier: GPL-3.0-or-later

/** x, y, z in the model's coordinates. */
export type Vector = number[];

/** The camera that the element has. Directions have the length 1. */
export interface ViewerCamera {
  position: Vector;
  /** The direction in which it looks. */
  direction: Vector;
  /** The upward direction in its picture. */
  up: Vector;
  /** The angle from the picture's top to its bottom, degrees. */
  fov: number;
}

/** A camera to set. Fields that are absent stay as they are, except `up`, which becomes the model's. */
export interface WantedCamera {
  position?: Vector;
  direction?: Vector;
  /** A point to look at, instead of `direction`. */
  target?: Vector;
  up?: Vector;
  /** In (0, 170), degrees. */
  fov?: number;
}

/** A point of the surface that the model's owner explains. */
export interface OwnersAnnotation {
  point: Vector;
  title: string;
  text: string;
}

/** What the owner's file says of a model; texts are empty where it says none. */
export interface OwnersPage {
  title: string;
  description: string;
  /** The unit of lengths, and how many of it a scene unit is. */
  unit: {name: string, length: number} | null;
  annotations: OwnersAnnotation[];
}

export interface LumatlasViewerEventMap {
  /** Every file is loaded that the server has. */
  load: CustomEvent<null>;
  /** Another photograph was loaded, or failed to load. `total` counts the model's photographs. */
  progress: CustomEvent<{done: number, total: number}>;
  /** A file failed to load. Unless that is final, the element asks for it again. */
  error: CustomEvent<{message: string, final: boolean}>;
  /** A headset shows the model from now on, or no more. */
  vr: CustomEvent<{shows: boolean}>;
  /** The camera has moved; at most once a frame. */
  viewchange: CustomEvent<ViewerCamera>;
}

/** `<lumatlas-viewer>` */
export class LumatlasViewerElement extends HTMLElement {
  /** The address of a model: a folder, its tileset.json, or a .glb. */
  src: string;
  /** Shows another model. Resolves with the event "load", and rejects if the model cannot be loaded. */
  load(src: string): Promise<void>;
  /** Moves the camera to a photograph, given by its name or number, or to a given camera. `duration`: of the movement,
   *  milliseconds, 700 by default. Resolves on arrival, or when the visitor moves the camera. Rejects with a RangeError
   *  if there is no such photograph or camera. */
  goTo(target: string | number | WantedCamera, options?: {duration?: number}): Promise<void>;
  /** Resolves with the present view as a PNG, once it is drawn sharp. */
  screenshot(): Promise<Blob>;
  /** Resolves with the share of the present picture that was photographed from near there, in [0, 1]. */
  coverage(): Promise<number>;
  /** Shows the model in the visitor's headset (WebXR). A click must call it. Rejects where the browser or the visitor
   *  refuses, or while there is no model. */
  enterVr(): Promise<void>;
  /** Ends what enterVr() began. */
  exitVr(): void;
  /** Sentences on what is missing now; empty: nothing. */
  readonly errors: string[];
  /** The names of the model's photographs. */
  readonly views: string[];
  /** What the owner's file says; null while there is no model. */
  readonly owner: OwnersPage | null;
  /** Throws an Error while there is no model. */
  get camera(): ViewerCamera;
  set camera(camera: WantedCamera);

  addEventListener<K extends keyof LumatlasViewerEventMap>(
      type: K, listener: (this: LumatlasViewerElement, event: LumatlasViewerEventMap[K]) => unknown,
      options?: boolean | AddEventListenerOptions): void;
  addEventListener(
      type: string, listener: EventListenerOrEventListenerObject, options?: boolean | AddEventListenerOptions): void;
  removeEventListener<K extends keyof LumatlasViewerEventMap>(
      type: K, listener: (this: LumatlasViewerElement, event: LumatlasViewerEventMap[K]) => unknown,
      options?: boolean | EventListenerOptions): void;
  removeEventListener(
      type: string, listener: EventListenerOrEventListenerObject, options?: boolean | EventListenerOptions): void;
}

declare global {
  interface HTMLElementTagNameMap {
    'lumatlas-viewer': LumatlasViewerElement;
  }
}

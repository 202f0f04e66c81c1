// SPDX-License-Identifier: GPL-3.0-or-later
import type {Object3D, Object3DEventMap, PerspectiveCamera, WebGLRenderer} from 'three';

export interface LoadOptions {
  /** MiB that the model may take on the GPU; 200, or 100 on a phone, by default. */
  memory?: number;
  /** Ends the model, as dispose() does. */
  signal?: AbortSignal;
  /** Called after each photograph that came, or could not be had. */
  progress?: (done: number, total: number) => void;
}

export interface LumatlasObjectEventMap extends Object3DEventMap {
  /** The model would look different in the next frame. Pages that draw on demand draw one then. */
  change: {};
}

/** A model in a scene of three.js. It may be moved, turned and scaled evenly. */
export class LumatlasObject extends Object3D<LumatlasObjectEventMap> {
  /** Resolves once the surface is there; photographs come afterwards. Rejects where the model cannot be had. `src` is
   *  the address of a folder, its tileset.json, or a .glb. */
  static load(src: string, renderer: WebGLRenderer, options?: LoadOptions): Promise<LumatlasObject>;
  private constructor();
  readonly isLumatlasObject: true;
  /** Resolves once every file is loaded that the server has. */
  readonly loaded: Promise<void>;
  /** Side of the model's picture as a share of that of three's, in (0, 1]; fewer pixels are drawn faster. */
  resolution: number;
  /** Draws the far sphere, which shows sky and distant surroundings, or not. */
  far: boolean;
  /** Sentences on what is missing now, or why it is not drawn; empty: nothing. */
  readonly errors: string[];
  /** The names of the model's photographs. */
  readonly views: string[];
  /** The upward direction of the model, in the object's own coordinates: x, y, z. */
  readonly modelUp: [number, number, number];
  /** Puts a camera where a photograph was taken, by name or number, so that its picture shows all of it; without one,
   *  where the model is seen first. The object's world matrix must be up to date. Throws a RangeError if there is no
   *  such photograph. */
  placeCamera(camera: PerspectiveCamera, view?: string | number): void;
  /** Takes it out of its scene, and deletes what is on the GPU. */
  dispose(): void;
}

// What is shown: a mesh in one of its looks, or a cloud of points.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  DynamicDrawUsage,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  Points,
  PointsMaterial,
  SRGBColorSpace,
  Texture,
  TextureLoader,
  Vector3,
} from 'three'
import type { Material, Raycaster } from 'three'
import { acceleratedRaycast, MeshBVH } from 'three-mesh-bvh'

import { scaleColor } from './colors'
import { joinedCorners, smoothNormals, spread } from './corners'
import type { Corners } from './corners'
import { drawnByProcessor } from './detail'
import type { MeshData } from './mesh_data'

Mesh.prototype.raycast = acceleratedRaycast

export type Look = 'plain' | 'texture' | 'colors' | 'confidence' | 'values'

/** A place on the surface under the pointer. */
export interface Hit {
  face: number
  barycentric: [number, number, number]
  place: [number, number, number]
  /** time that the search took [ms] */
  ms: number
}

/** Pictures in the mesh's layout, as far as they are loaded. */
export interface Pictures {
  texture: Texture | null
  confidence: Texture | null
}

/** A picture from an address, as a texture in sRGB. */
export async function loadedTexture(url: string): Promise<Texture> {
  const texture = await new TextureLoader().loadAsync(url)
  texture.colorSpace = SRGBColorSpace
  texture.anisotropy = drawnByProcessor() ? 1 : 4
  return texture
}

/** A picture that was decoded upside down, as graphics cards take it. */
export function decodedTexture(picture: ImageBitmap): Texture {
  const texture = new Texture(picture)
  texture.colorSpace = SRGBColorSpace
  texture.anisotropy = drawnByProcessor() ? 1 : 4
  texture.flipY = false
  texture.needsUpdate = true
  // Of the picture itself both are 0 once it is freed.
  texture.userData.size = `${picture.width} ${picture.height}`
  return texture
}

/** Puts another decoded picture of the same size on a texture; false: another size, or texture. */
export function changePicture(texture: Texture | null, picture: ImageBitmap): boolean {
  if (texture?.userData.size !== `${picture.width} ${picture.height}`) return false
  texture.image = picture
  texture.needsUpdate = true
  return true
}

const kMapChunk = '#include <map_fragment>'
const kBlend = 'uniform sampler2D second;\nuniform float share;\n'
/** Stored values are mixed, not light: so does the film. */
const kBlendedMap = `
#ifdef USE_MAP
  vec4 under = texture2D(map, vMapUv);
  if (share > 0.0) {
    vec4 over = sRGBTransferOETF(texture2D(second, vMapUv));
    under = sRGBTransferEOTF(mix(sRGBTransferOETF(under), over, share));
  }
  diffuseColor *= under;
#endif`

/** The scale's colours as the renderer takes them: 256 levels, then that of 'no value'. */
const kLinearScale = new Float32Array(
  Array.from({ length: 257 }, (_, level) => {
    const [r, g, b] = level < 256 ? scaleColor(level / 255) : [0.6, 0.6, 0.6]
    return new Color().setRGB(r, g, b, SRGBColorSpace).toArray()
  }).flat(),
)

/** The colours of a vertex for each of its corners, as the renderer takes them. */
function linearColors(data: MeshData, vertexOf: Uint32Array): Float32Array {
  const colors = new Float32Array(3 * vertexOf.length)
  const color = new Color()
  for (let corner = 0; corner < vertexOf.length; ++corner) {
    const from = 4 * vertexOf[corner]
    const part = (k: number) => data.colors![from + k] / 255
    color.setRGB(part(0), part(1), part(2), SRGBColorSpace).toArray(colors, 3 * corner)
  }
  return colors
}

/** Positions and normals that change with each picture of an animation. */
const changing = (count: number) =>
  new BufferAttribute(new Float32Array(3 * count), 3).setUsage(DynamicDrawUsage)

function geometryOf(corners: Corners): BufferGeometry {
  const { index, vertexOf, uvs } = corners
  const geometry = new BufferGeometry()
  geometry.setIndex(new BufferAttribute(index, 1))
  geometry.setAttribute('position', changing(vertexOf.length))
  geometry.setAttribute('normal', changing(vertexOf.length))
  if (uvs) geometry.setAttribute('uv', new BufferAttribute(uvs, 2))
  return geometry
}

function makeCloud(data: MeshData): Points {
  const geometry = new BufferGeometry()
  geometry.setAttribute('position', new BufferAttribute(data.positions, 3))
  if (data.colors) geometry.setAttribute('color', new BufferAttribute(data.colors, 4, true))
  const material = new PointsMaterial({
    size: 1.6,
    sizeAttenuation: false,
    vertexColors: data.colors !== null,
    color: data.colors ? '#ffffff' : '#8d8574',
  })
  // The colours of a cloud are sRGB bytes; the renderer takes vertex colours for linear ones.
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader.replace(
      '#include <color_vertex>',
      `#include <color_vertex>
#ifdef USE_COLOR_ALPHA
 vColor = vec4(pow(vColor.rgb, vec3(2.2)), 1.0);
#elif defined(USE_COLOR)
 vColor = pow(vColor, vec3(2.2));
#endif`,
    )
  }
  return new Points(geometry, material)
}

export class Surface {
  readonly data: MeshData
  readonly object: Mesh | Points
  private readonly mesh: Mesh | null
  private readonly corners: Corners
  /** of the vertices; kept, so that a picture of an animation makes nothing new */
  private readonly normals: Float32Array
  /** what lies over the picture, as the shader takes it */
  private readonly over = { second: { value: null as Texture | null }, share: { value: 0 } }

  constructor(
    shown: MeshData,
    look: Look,
    private readonly pictures: Pictures,
  ) {
    // A copy: an animation puts other positions here.
    const data = { ...shown }
    this.data = data
    this.corners = joinedCorners(data)
    this.normals = new Float32Array(data.faces > 0 ? 3 * data.vertices : 0)
    this.mesh = data.faces > 0 ? new Mesh(geometryOf(this.corners)) : null
    this.object = this.mesh ?? makeCloud(data)
    if (this.mesh) {
      this.place(data.positions)
      this.shade()
      this.mesh.geometry.boundsTree = new MeshBVH(this.mesh.geometry, { indirect: true })
    }
    // setPositions may move it out of the ball that three.js remembers.
    if (this.mesh) this.mesh.frustumCulled = false
    this.setLook(look)
  }

  dispose(): void {
    this.object.geometry.dispose()
    ;(this.object.material as Material).dispose()
  }

  setLook(look: Look): void {
    if (!this.mesh) return
    const old = this.mesh.material as Material
    this.mesh.material = this.materialOf(look)
    old.dispose()
  }

  /** A share of a second picture comes over the first, which stays if there is no other. */
  blend(first: Texture | null, second: Texture | null, share: number): void {
    const shown = this.mesh?.material
    if (!(shown instanceof MeshBasicMaterial) || shown.userData.picture !== 'texture') return
    const before = shown.map
    shown.map = first ?? before
    this.over.second.value = second
    this.over.share.value = second ? share : 0
    if (!before !== !shown.map) shown.needsUpdate = true
  }

  /** The pictures have changed. */
  showPictures(): void {
    const shown = this.mesh?.material as MeshBasicMaterial | MeshStandardMaterial | undefined
    const picture = shown && (shown.userData.picture as keyof Pictures | undefined)
    if (!shown || !picture) return
    shown.map = this.pictures[picture]
    shown.needsUpdate = true
  }

  private materialOf(look: Look): Material {
    const { data, pictures } = this
    if (look === 'texture' && data.uvs) {
      const material = new MeshBasicMaterial({ map: pictures.texture, side: DoubleSide })
      material.userData.picture = 'texture'
      material.onBeforeCompile = (shader) => {
        Object.assign(shader.uniforms, this.over)
        shader.fragmentShader = kBlend + shader.fragmentShader.replace(kMapChunk, kBlendedMap)
      }
      return material
    }
    if (look === 'confidence' && data.uvs) {
      const map = pictures.confidence
      const material = new MeshStandardMaterial({ map, roughness: 0.9, side: DoubleSide })
      material.userData.picture = 'confidence'
      return material
    }
    if (look === 'colors' && data.colors) {
      const colors = new BufferAttribute(linearColors(data, this.corners.vertexOf), 3)
      this.mesh!.geometry.setAttribute('color', colors)
      return new MeshBasicMaterial({ vertexColors: true, side: DoubleSide })
    }
    return new MeshStandardMaterial({ color: '#c9bfae', roughness: 0.85, side: DoubleSide })
  }

  /** Vertices become a colour each: [0, 1] from low to high, or `none` where not finite. */
  showValues(values: Float32Array, none: string): void {
    if (!this.mesh) return
    new Color(none).toArray(kLinearScale, 3 * 256)
    const { vertexOf } = this.corners
    const corners = vertexOf.length
    const old = this.mesh.geometry.getAttribute('color') as BufferAttribute | undefined
    const colors = (old?.array as Float32Array) ?? new Float32Array(3 * corners)
    for (let corner = 0; corner < corners; ++corner) {
      const value = values[vertexOf[corner]]
      const level = Math.round(255 * Math.min(1, Math.max(0, value)))
      const from = Number.isFinite(value) ? 3 * level : 3 * 256
      colors[3 * corner] = kLinearScale[from]
      colors[3 * corner + 1] = kLinearScale[from + 1]
      colors[3 * corner + 2] = kLinearScale[from + 2]
    }
    if (old) old.needsUpdate = true
    else this.mesh.geometry.setAttribute('color', new BufferAttribute(colors, 3))
    const material = this.mesh.material
    // A brush calls this many times a second; the material is compiled only once.
    if (material instanceof MeshStandardMaterial && material.vertexColors) return
    this.mesh.material = new MeshStandardMaterial({
      vertexColors: true,
      roughness: 0.9,
      side: DoubleSide,
    })
  }

  setPositions(positions: Float32Array, normals: boolean): void {
    if (!this.mesh) return
    this.data.positions = positions
    this.place(positions)
    if (normals && this.mesh.material instanceof MeshStandardMaterial) this.shade()
  }

  private place(positions: Float32Array): void {
    this.write('position', positions)
  }

  private shade(): void {
    smoothNormals(this.data.indices, this.data.positions, this.normals)
    this.write('normal', this.normals)
  }

  private write(name: string, values: Float32Array): void {
    const target = this.mesh!.geometry.getAttribute(name) as BufferAttribute
    spread(this.corners.vertexOf, values, target.array as Float32Array)
    target.needsUpdate = true
  }

  /** The first place that the ray meets, or null. */
  hit(ray: Raycaster): Omit<Hit, 'ms'> | null {
    if (!this.mesh) return null
    ray.firstHitOnly = true
    const found = ray.intersectObject(this.mesh, false)[0]
    if (!found || found.faceIndex == null) return null
    return {
      face: found.faceIndex,
      barycentric: this.barycentricOf(found.faceIndex, found.point),
      place: [found.point.x, found.point.y, found.point.z],
    }
  }

  /** The place of a pick on the shown mesh. */
  placeOf(face: number, barycentric: number[]): [number, number, number] {
    const place: [number, number, number] = [0, 0, 0]
    if (face < 0 || face >= this.data.faces) return place
    for (let corner = 0; corner < 3; ++corner) {
      const vertex = this.data.indices[3 * face + corner]
      for (let k = 0; k < 3; ++k)
        place[k] += barycentric[corner] * this.data.positions[3 * vertex + k]
    }
    return place
  }

  /** Vertices nearer to a place than `reach`, with their distance over it. */
  verticesNear(place: [number, number, number], reach: number): { vertex: number; at: number }[] {
    const found: { vertex: number; at: number }[] = []
    const p = this.data.positions
    for (let v = 0; v < this.data.vertices; ++v) {
      const d = Math.hypot(p[3 * v] - place[0], p[3 * v + 1] - place[1], p[3 * v + 2] - place[2])
      if (d < reach) found.push({ vertex: v, at: d / reach })
    }
    return found
  }

  private barycentricOf(face: number, point: Vector3): [number, number, number] {
    const corner = (k: number) => {
      const vertex = 3 * this.data.indices[3 * face + k]
      const p = this.data.positions
      return new Vector3(p[vertex], p[vertex + 1], p[vertex + 2])
    }
    const [a, b, c] = [corner(0), corner(1), corner(2)]
    const normal = b.clone().sub(a).cross(c.clone().sub(a))
    const area = normal.lengthSq() || 1
    const share = (u: Vector3, v: Vector3) =>
      u.clone().sub(point).cross(v.clone().sub(point)).dot(normal) / area
    const first = Math.min(1, Math.max(0, share(b, c)))
    const second = Math.min(1 - first, Math.max(0, share(c, a)))
    return [first, second, 1 - first - second]
  }
}

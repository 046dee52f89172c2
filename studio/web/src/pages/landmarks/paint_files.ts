// Painted stiffness and regions as the server keeps them; saves each stroke at once.
import { useEffect, useMemo, useReducer, useRef } from 'preact/hooks'

import { api, ApiError } from '../../api'
import { useStudio } from '../../state'
import { useUnsavedGuard } from '../poses/route'
import type { MeshData } from '../../view/mesh_data'
import { kStiffness, Painting, regionLayer } from './painting'

interface Files {
  painting: Painting
  /** in the order of the file */
  regions: string[]
  revision: { stiffness: string; regions: string }
  dirty: { stiffness: boolean; regions: boolean }
  saving: boolean
  failed: string
  loaded: boolean
}

export interface PaintFiles {
  files: Files
  /** Call after a layer has changed. */
  changed: (layer: string) => void
  addRegion: (name: string) => void
  removeRegion: (name: string) => void
  retry: () => void
}

function newFiles(vertices: number): Files {
  const painting = new Painting(vertices)
  painting.layer(kStiffness, 1)
  return {
    painting,
    regions: [],
    revision: { stiffness: '', regions: '' },
    dirty: { stiffness: false, regions: false },
    saving: false,
    failed: '',
    loaded: false,
  }
}

function membersOf(painting: Painting, name: string): number[] {
  const members: number[] = []
  painting.layer(regionLayer(name)).forEach((value, vertex) => value > 0 && members.push(vertex))
  return members
}

async function loadStiffness(files: Files, vertices: number, force: boolean): Promise<boolean> {
  const { revision, values } = await api.stiffness()
  if (!force && (files.dirty.stiffness || files.saving)) return false
  if (!force && files.loaded && revision === files.revision.stiffness) return false
  if (values && values.length !== vertices)
    throw new Error('The painted stiffness belongs to another mesh; it is not shown.')
  files.revision.stiffness = revision
  files.painting.setLayer(kStiffness, Float32Array.from(values ?? Array(vertices).fill(1)))
  return true
}

async function loadRegions(files: Files, vertices: number, force: boolean): Promise<boolean> {
  const { revision, regions } = await api.regions()
  if (!force && (files.dirty.regions || files.saving)) return false
  if (!force && files.loaded && revision === files.revision.regions) return false
  files.revision.regions = revision
  for (const name of files.regions) files.painting.dropLayer(regionLayer(name))
  files.regions = Object.keys(regions)
  for (const [name, members] of Object.entries(regions)) {
    const values = new Float32Array(vertices)
    for (const vertex of members) if (vertex < vertices) values[vertex] = 1
    files.painting.setLayer(regionLayer(name), values)
  }
  return true
}

async function saveStiffness(files: Files): Promise<void> {
  files.dirty.stiffness = false
  const values = files.painting.layer(kStiffness)
  const plain = values.every((value) => value === 1)
  // Rounded, as 0.125 and 8 are exact in any case and other files keep six digits.
  const numbers = plain ? null : Array.from(values, (value) => Number(value.toPrecision(6)))
  const answer = await api.saveStiffness(numbers, files.revision.stiffness)
  files.revision.stiffness = answer.revision
}

async function saveRegions(files: Files): Promise<void> {
  files.dirty.regions = false
  const lists = files.regions.map((name) => [name, membersOf(files.painting, name)] as const)
  const answer = await api.saveRegions(Object.fromEntries(lists), files.revision.regions)
  files.revision.regions = answer.revision
}

type Kind = 'stiffness' | 'regions'

/**
 * Both kinds one after the other, until nothing is left.
 * @param changedElsewhere  reads a kind anew, of which somebody else has written the file
 */
async function saveAll(
  files: Files,
  changedElsewhere: (kind: Kind) => Promise<void>,
): Promise<void> {
  while (files.dirty.stiffness || files.dirty.regions) {
    const kind = files.dirty.stiffness ? 'stiffness' : 'regions'
    try {
      await (kind === 'stiffness' ? saveStiffness(files) : saveRegions(files))
    } catch (error) {
      if (error instanceof ApiError && error.status === 409) {
        await changedElsewhere(kind)
        continue
      }
      files.dirty[kind] = true
      throw error
    }
  }
}

export function usePaintFiles(data: MeshData | null, onLoad: () => void): PaintFiles {
  const { version, tell, complain } = useStudio()
  const [, redraw] = useReducer((count: number) => count + 1, 0)
  const vertices = data?.vertices ?? 0
  const files = useMemo(() => newFiles(vertices), [data])
  const loadedNow = useRef(onLoad)
  loadedNow.current = onLoad

  const load = async () => {
    const first = await loadStiffness(files, vertices, false)
    const second = await loadRegions(files, vertices, false)
    files.loaded = true
    if (first || second) loadedNow.current()
    redraw(0)
  }

  const readAnew = async (kind: Kind) => {
    await (kind === 'stiffness' ? loadStiffness : loadRegions)(files, vertices, true)
    files.dirty[kind] = false
    loadedNow.current()
    tell('The paint was changed elsewhere. It is shown as it is now, without your stroke.')
  }
  const save = async () => {
    if (files.saving) return
    files.saving = true
    files.failed = ''
    redraw(0)
    try {
      await saveAll(files, readAnew)
    } catch (error) {
      files.failed = error instanceof Error ? error.message : String(error)
    }
    files.saving = false
    redraw(0)
  }
  useEffect(() => {
    if (!data) return
    // A stroke that could not be saved, perhaps as the studio was away, is tried again.
    load()
      .then(() => (files.failed ? save() : undefined))
      .catch(complain)
  }, [files, version])
  useUnsavedGuard(files.failed !== '')
  const changed = (layer: string) => {
    if (layer === kStiffness) files.dirty.stiffness = true
    else files.dirty.regions = true
    void save()
  }
  return {
    files,
    changed,
    addRegion: (name) => {
      files.painting.layer(regionLayer(name))
      files.regions = [...files.regions, name]
      redraw(0)
    },
    removeRegion: (name) => {
      files.painting.dropLayer(regionLayer(name))
      files.regions = files.regions.filter((one) => one !== name)
      changed(regionLayer(name))
    },
    retry: () => void save(),
  }
}

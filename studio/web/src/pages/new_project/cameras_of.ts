// What was chosen of a performance, by camera.
import type { Item } from '../../uploads/upload_model'
import { count } from '../../words'

/** Folders beside the cameras' own. */
export const isBeside = (name: string) => /^(masks|background)(\/|$)/.test(name)

/** What each camera has: "cam1.mp4", or "cam1: 120 pictures"; then masks and empty sets. */
export function camerasOf(items: Item[]): { name: string; words: string }[] {
  const folders = new Map<string, number>()
  for (const { name } of items) {
    const key = name.includes('/') ? name.slice(0, name.lastIndexOf('/')) : name
    folders.set(key, (folders.get(key) ?? 0) + 1)
  }
  const beside = (name: string) => Number(isBeside(name))
  const sorted = [...folders].sort(([one], [other]) => beside(one) - beside(other))
  return sorted.map(([name, pictures]) => ({
    name,
    words: items.some((one) => one.name === name) ? name : `${name}: ${count(pictures, 'picture')}`,
  }))
}

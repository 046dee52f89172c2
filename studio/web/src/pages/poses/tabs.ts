// What there is to see of a pose.
import type { Pose } from '../../api'

export type Tab = 'photographs' | 'figure' | '3d' | 'mend' | 'fit' | 'wipe'
export const kTabs: Tab[] = ['photographs', 'figure', '3d', 'mend', 'fit', 'wipe']

/** Whether a pose has a mesh from elsewhere in place of photographs. */
export function isFromMesh(pose: Pose): boolean {
  return pose.mesh !== '' && pose.photographs === 0
}

export function tabsOf(pose: Pose): Tab[] {
  return kTabs.filter(
    (tab) =>
      (tab !== 'fit' || !pose.template) &&
      ((tab !== 'photographs' && tab !== 'figure' && tab !== 'wipe') || !isFromMesh(pose)),
  )
}

// Making the project and sending its photographs. It lives outside of the page's components: the
// project exists from the first moment, and the shell would leave the page while files still go.
import { useEffect, useState } from 'preact/hooks'

import { api, ApiError } from '../../api'
import type { Photo } from './files'

export interface Send {
  pose: string
  photo: Photo
}
export interface Failed extends Send {
  why: string
}
export interface Upload {
  state: 'sending' | 'ended' | 'cancelled'
  sent: number
  total: number
  bytesSent: number
  bytesTotal: number
  /** what is being sent */
  now: string
  failed: Failed[]
  /** not sent, after a cancel or a lost connection */
  left: Send[]
}

const kNothing: Upload = {
  state: 'sending',
  sent: 0,
  total: 0,
  bytesSent: 0,
  bytesTotal: 0,
  now: '',
  failed: [],
  left: [],
}

/** Pure. A project whose photographs did not all arrive is not said to be made. */
export function headOf({ state, failed, sent }: Upload): string {
  if (state === 'sending') return 'Sends the photographs'
  if (state === 'cancelled') return 'Stopped'
  if (failed.length === 0) return 'The project is made'
  return failed.length === sent ? 'No photograph was taken' : 'Not all photographs were taken'
}

let upload: Upload | null = null
let cancelled = false
const listeners = new Set<() => void>()

function set(next: Upload | null): void {
  upload = next
  for (const listener of listeners) listener()
}
const change = (fields: Partial<Upload>) => upload && set({ ...upload, ...fields })

/** The upload under way or just ended, or null. The page New project stays while there is one. */
export function useUpload(): Upload | null {
  const [, redraw] = useState(0)
  useEffect(() => {
    const listener = () => redraw((old) => old + 1)
    listeners.add(listener)
    return () => void listeners.delete(listener)
  }, [])
  return upload
}

/** A page that is closed in the middle would lose the rest: the browser asks first. */
const warn = (event: BeforeUnloadEvent) => event.preventDefault()

async function sendOne(one: Send): Promise<'sent' | 'failed' | 'lost'> {
  change({ now: `${one.pose}/${one.photo.name}` })
  try {
    await api.addPhotograph(one.pose, one.photo.name, one.photo.file)
    return 'sent'
  } catch (error) {
    if (error instanceof ApiError && error.status === 0) return 'lost'
    const why = error instanceof Error ? error.message : String(error)
    change({ failed: [...upload!.failed, { ...one, why }] })
    return 'failed'
  }
}

/** One after the other: the disk is the bottleneck, and errors stay in order. */
export async function send(list: Send[]): Promise<Upload> {
  cancelled = false
  const bytesTotal = list.reduce((sum, one) => sum + one.photo.file.size, 0)
  set({ ...kNothing, total: list.length, bytesTotal })
  addEventListener('beforeunload', warn)
  let i = 0
  for (; i < list.length && !cancelled; ++i) {
    if ((await sendOne(list[i])) === 'lost') break
    change({ sent: upload!.sent + 1, bytesSent: upload!.bytesSent + list[i].photo.file.size })
  }
  removeEventListener('beforeunload', warn)
  change({ state: i < list.length ? 'cancelled' : 'ended', left: list.slice(i), now: '' })
  return upload!
}

export function cancel(): void {
  cancelled = true
}

/** Leaves the page: the project is there, whatever has been sent. */
export function leave(): void {
  set(null)
}

/** Holds the page while the project is being made, before the first photograph goes. */
export async function making<T>(make: () => Promise<T>): Promise<T> {
  set(kNothing)
  try {
    return await make()
  } catch (error) {
    set(null)
    throw error
  }
}

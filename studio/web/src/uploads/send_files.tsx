// Files for the project: chosen or dropped, on their way with a bar, and what was not taken and why.
import type { ComponentChildren } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'

import { Bar } from '../bar'
import { hasFiles } from '../stray_drops'
import { useStudio } from '../state'
import { bytes, count, sentence } from '../words'
import { Chooser } from '../pages/new_project/chooser'
import { dropped } from '../pages/new_project/files'
import type { Found } from '../pages/new_project/files'
import { sendFile } from './upload'
import { itemsFor, kAccepts } from './upload_model'
import type { Item, Place } from './upload_model'
import './uploads.css'

export interface Sending {
  /** [bytes] */
  sent: number
  total: number
  now: string
}

/** A page that is closed in the middle would lose the rest: the browser asks first. */
const warn = (event: BeforeUnloadEvent) => event.preventDefault()

export function useSending(place: Place, shot = '') {
  const { reload } = useStudio()
  const [sending, setSending] = useState<Sending | null>(null)
  const [failed, setFailed] = useState<string[]>([])
  const stopped = useRef(false)
  useEffect(() => () => void (stopped.current = true), [])

  /** @returns paths in the project of those that have arrived */
  const send = async (items: Item[], leftOut: string[] = [], of = shot): Promise<string[]> => {
    const total = items.reduce((sum, one) => sum + one.file.size, 0)
    const wrong = leftOut.length > 0 ? [`${count(leftOut.length, 'file')} left out: ${leftOut[0]}`] : []
    const arrived: string[] = []
    stopped.current = false
    setFailed(wrong)
    addEventListener('beforeunload', warn)
    let before = 0
    for (const item of items) {
      if (stopped.current) break
      setSending({ sent: before, total, now: item.name })
      const told = (sent: number) => setSending({ sent: before + sent, total, now: item.name })
      await sendFile({ place, shot: of }, item, told, () => stopped.current).then(
        (path) => arrived.push(path),
        (error: Error) => wrong.push(error.message),
      )
      before += item.file.size
    }
    removeEventListener('beforeunload', warn)
    setSending(null)
    setFailed([...wrong])
    await reload()
    return arrived
  }
  return { sending, failed, send, stop: () => void (stopped.current = true) }
}

export function SendingBar({ sending, stop }: { sending: Sending; stop: () => void }) {
  return (
    <div class="stack send-bar" role="status">
      <Bar label="Files sent" share={sending.total > 0 ? sending.sent / sending.total : 0} />
      <div class="row spread small">
        <span class="soft">{sending.now}</span>
        <span class="soft number">
          {bytes(sending.sent)} of {bytes(sending.total)}
        </span>
        <button class="quiet" onClick={stop}>
          Stop
        </button>
      </div>
    </div>
  )
}

export function Faults({ failed }: { failed: string[] }) {
  if (failed.length === 0) return null
  return (
    <ul class="send-faults bad small" role="alert">
      {failed.slice(0, 6).map((words) => (
        <li key={words}>{sentence(words)}</li>
      ))}
      {failed.length > 6 && <li>And {failed.length - 6} more.</li>}
    </ul>
  )
}

/** A place to drop files on, with buttons that choose them. */
export function DropFiles(props: {
  place: Place
  words: string
  /** also a whole folder, of pictures */
  folder?: boolean
  add: (found: Found[]) => void
  children?: ComponentChildren
}) {
  const [over, setOver] = useState(false)
  return (
    <div
      class={over ? 'send-drop over' : 'send-drop'}
      onDragOver={(event) => {
        if (!hasFiles(event)) return
        event.preventDefault()
        setOver(true)
      }}
      onDragLeave={() => setOver(false)}
      onDrop={(event) => {
        event.preventDefault()
        event.stopPropagation()
        setOver(false)
        if (event.dataTransfer) void dropped(event.dataTransfer).then(props.add)
      }}
    >
      <p class="soft">{props.words}</p>
      <div class="row">
        <Chooser folder={false} words="Choose files" accept={kAccepts[props.place]} add={props.add} />
        {props.folder && <Chooser folder words="Choose a folder" add={props.add} />}
      </div>
      {props.children}
    </div>
  )
}

/** The whole: sent as soon as it is chosen or dropped. */
export function SendFiles(props: {
  place: Place
  shot?: string
  words: string
  folder?: boolean
  done?: (paths: string[]) => void
}) {
  const { sending, failed, send, stop } = useSending(props.place, props.shot)
  const add = (found: Found[]) => {
    const { items, leftOut } = itemsFor(props.place, found)
    void send(items, leftOut).then((paths) => paths.length > 0 && props.done?.(paths))
  }
  return (
    <div class="send">
      {sending ? (
        <SendingBar sending={sending} stop={stop} />
      ) : (
        <DropFiles place={props.place} words={props.words} folder={props.folder} add={add} />
      )}
      <Faults failed={failed} />
    </div>
  )
}

// A step's last output; while the step is at work it is read again each second, and followed.
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import { useStudio } from '../../state'

const kAgainMs = 1000

export function Log({ id, isRunning }: { id: string; isRunning: boolean }) {
  const { version, complain } = useStudio()
  const [text, setText] = useState<string | null>(null)
  const box = useRef<HTMLPreElement>(null)
  const follows = useRef(true)

  useEffect(() => {
    setText(null)
    follows.current = true
  }, [id])
  useEffect(() => {
    let alive = true
    const read = () =>
      api
        .log(id)
        .then((log) => alive && setText(log))
        .catch((error) => {
          if (!alive) return
          setText('')
          complain(error)
          clearInterval(timer) // told once is enough
        })
    const timer = isRunning ? setInterval(read, kAgainMs) : undefined
    void read()
    return () => {
      alive = false
      clearInterval(timer)
    }
  }, [id, isRunning, version, complain])
  useEffect(() => {
    // A reader who has scrolled up stays there.
    if (box.current && follows.current) box.current.scrollTop = box.current.scrollHeight
  }, [text])

  if (text === null) return <p class="soft">Reads the log …</p>
  if (text.trim() === '')
    return <p class="soft">{isRunning ? 'Nothing said so far.' : 'No log: it has not run yet.'}</p>
  return (
    <pre
      ref={box}
      class="run-log"
      tabIndex={0}
      aria-label={`Log of ${id}`}
      onScroll={() => {
        const at = box.current!
        follows.current = at.scrollHeight - at.scrollTop - at.clientHeight < 24
      }}
    >
      {text}
    </pre>
  )
}

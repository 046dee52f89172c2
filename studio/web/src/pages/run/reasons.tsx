// Why a step would run, or last ran: the words of `keypose explain`, laid out to be read.
import type { ComponentChildren } from 'preact'

import { useStudio } from '../../state'
import { stepName } from '../../words'
import { Icon } from './icons'

export interface Block {
  /** the step that it is about, or '' */
  id: string
  /** the first line without the step's name */
  head: string
  waits: string[]
  reasons: string[]
  /** other lines, such as the error of the last try */
  notes: string[]
}

const kWaits = /^waits for (.*); whether it runs depends on their results$/

function blockOf(id: string, words: string): Block {
  const waits = kWaits.exec(words)?.[1].split(', ') ?? []
  const head = waits.length > 0 ? 'waits for' : words.replace('is up to date', 'up to date')
  return { id, head, waits, reasons: [], notes: [] }
}

/** Pure: the paragraphs of the text. Words that it does not know become notes, never lost. */
export function parseExplanation(text: string): Block[] {
  const blocks: Block[] = []
  for (const line of text.split('\n')) {
    const head = /^(\S+) (would run because|is up to date|waits for .*)$/.exec(line)
    const reason = /^ {2}- (.*)$/.exec(line)
    const last = blocks[blocks.length - 1]
    if (head) blocks.push(blockOf(head[1], head[2]))
    else if (reason && last) last.reasons.push(reason[1])
    else if (last && /^it (last ran|was found)/.test(line)) last.head += `; ${line.slice(3)}`
    else if (line.trim() && last) last.notes.push(line.trim())
    else if (line.trim()) blocks.push({ ...blockOf('', ''), notes: [line.trim()] })
  }
  return blocks
}

/** "option levels: 3 -> 4" as the field and both values; "a.jpg changed" as file and fate. */
export function Reason({ text }: { text: string }) {
  const change = /^(.*?): (.*) -> (.*)$/.exec(text)
  if (change)
    return (
      <li class="change">
        <span>{change[1]}</span>
        <s>{change[2] || 'empty'}</s>
        <Icon name="arrow" />
        <span class="hidden">is now</span>
        <b>{change[3] || 'empty'}</b>
      </li>
    )
  const file = /^(.*) (changed|is new|is gone)$/.exec(text)
  if (file)
    return (
      <li class="change">
        <code>{file[1]}</code>
        <b>{file[2]}</b>
      </li>
    )
  return <li>{text}</li>
}

function StepLinks({ ids, open }: { ids: string[]; open: (id: string) => void }) {
  const { steps } = useStudio().steps
  const shown = ids.length > 7 ? ids.slice(0, 6) : ids
  return (
    <span class="links">
      {shown.map((id) => (
        <button key={id} class="link" onClick={() => open(id)}>
          {stepName(id, steps)}
        </button>
      ))}
      {ids.length > shown.length && <span>and {ids.length - shown.length} more</span>}
    </span>
  )
}

export function Explanation(props: {
  text: string
  about: string
  /** the error of its last try stands elsewhere on the page */
  withoutNotes: boolean
  open: (id: string) => void
}) {
  const line = (block: Block): ComponentChildren => {
    const words = block.head.charAt(0).toUpperCase() + block.head.slice(1)
    if (block.id === props.about || block.id === '') return words
    return (
      <>
        <StepLinks ids={[block.id]} open={props.open} /> {block.head}
      </>
    )
  }
  return (
    <div class="run-why">
      {parseExplanation(props.text).map((block, i) => (
        <div key={i}>
          <p>
            {line(block)} {block.waits.length > 0 && (
              <StepLinks ids={block.waits} open={props.open} />
            )}
          </p>
          {block.reasons.length > 0 && (
            <ul>
              {block.reasons.map((reason, j) => (
                <Reason key={j} text={reason} />
              ))}
            </ul>
          )}
          {block.notes.length > 0 && !props.withoutNotes && (
            <p class="soft">{block.notes.join('\n')}</p>
          )}
        </div>
      ))}
    </div>
  )
}
